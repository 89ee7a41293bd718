// From scans that have found their place to one mesh, and what is told of it.
#pragma once

#include <stop_token>

#include "app/scan/align_inputs.h"
#include "app/scan/pipeline.h"

namespace scanknit {

/// Tells the report of scans and pairs. With `picture_folder` each pair gets its picture there, pair_A_B.png: the first
/// scan orange, the second blue, as they lie in the end (or at their best, for a pair that was refused). kOutput.
[[nodiscard]] Result<void> describe_alignment(const AlignInputs& inputs, const Alignment& alignment,
                                              const std::optional<std::filesystem::path>& picture_folder,
                                              RunReport& report);

/// Fuses all grids and raw frames into one volume, and writes what the job asks for. Errors: integrate()'s, kMesh,
/// kOutput.
[[nodiscard]] Result<void> fuse_aligned(const AlignInputs& inputs, const Alignment& alignment, const Job& job,
                                        std::stop_token stop, Console& console, RunReport& report);

/// All points of all scans in the world, with colours where all have some. kOutput.
[[nodiscard]] Result<void> write_aligned_points(const AlignInputs& inputs, const Alignment& alignment,
                                                const std::filesystem::path& path, RunReport& report);

/// A line for each pair, for people.
[[nodiscard]] std::string alignment_text(const RunReport& report);

}  // namespace scanknit
