// A short summary of a run, for stdout.
#pragma once

#include <string>

#include "app/report/run.h"

namespace scanknit {

/// Frames, voxels, triangles, size in millimetres, seconds of each stage, paths of the files, and a suggestion.
[[nodiscard]] std::string summary_text(const CommandRun& run);

}  // namespace scanknit
