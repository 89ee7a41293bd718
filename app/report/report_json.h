// report.json: a run in numbers. docs/report.md describes it, and tests check it against its schema.
#pragma once

#include <cstddef>
#include <string>

#include "app/report/run.h"
#include "scan/scan_result.h"

namespace scanknit {

/// One JSON document, keys as in docs/report.schema.json, ending in a newline. Numbers are numbers; bounds_m is
/// [[x,y,z],[x,y,z]].
[[nodiscard]] std::string report_json(const CommandRun& run);

/// "none", "rpm", "step", "file", "recording".
[[nodiscard]] const char* to_string(AngleSource source);

/// The number of frames in this state.
[[nodiscard]] std::size_t count_of(const TrackingResult& tracking, TrackState state);

}  // namespace scanknit
