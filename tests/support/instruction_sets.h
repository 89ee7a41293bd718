// Vectorised code gives the same bits on every processor: tests that run it once for each instruction set.
#pragma once

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cstdint>

namespace scanknit::test {

/// Calls check() once for each instruction set of this processor that Highway has code for.
template <typename Check>
void for_each_instruction_set(const Check& check) {
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    SCOPED_TRACE(hwy::TargetName(target));
    hwy::SetSupportedTargetsForTest(target);
    check();
  }
  hwy::SetSupportedTargetsForTest(0);
}

}  // namespace scanknit::test
