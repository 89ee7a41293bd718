// Tests that are run for GLB files plain, quantized, compressed and both.
#pragma once

#include <gtest/gtest.h>

#include "export/export_config.h"

namespace scanknit::test {

/// Over 0 to 3.
class EveryPacking : public ::testing::TestWithParam<int> {
 protected:
  [[nodiscard]] static ExportConfig config() {
    ExportConfig config;
    config.quantize = (GetParam() & 1) != 0;
    config.compress = (GetParam() & 2) != 0;
    return config;
  }
};

}  // namespace scanknit::test
