// ScanConfig: all settings of a run, room by room.
#pragma once

#include "acquire/acquire_config.h"
#include "export/export_config.h"
#include "extract/extract_config.h"
#include "finish/finish_config.h"
#include "fusion/fusion_config.h"

namespace scanknit {

/// Values and their ranges: docs/configuration.md, where each member is a key. The defaults scan a room.
struct ScanConfig {
  AcquireConfig acquire;
  ScannerSettings scanner;  ///< also keys of `acquire:`
  GivenNoise noise;         ///< the keys of `fusion.noise:`; a scan sets fusion.noise by it and the sensor
  FusionConfig fusion;
  TurntableConfig turntable;
  ExtractConfig extract;
  FinishConfig finish;
  ExportConfig output;  ///< the keys of `export:`, which is a C++ keyword
};

}  // namespace scanknit
