// What a run did, for a person: a few lines on stdout.
#pragma once

#include <string>

#include "app/report/run.h"

namespace scanknit {

/// Frames, voxels, triangles, size in millimetres, seconds a stage, where the files are, and what to try next.
[[nodiscard]] std::string summary_text(const CommandRun& run);

}  // namespace scanknit
