// fuse_parts: fuses some parts of a planned scan into files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "core/result.h"
#include "scan/bricks/planned_scan.h"
#include "scan/frames/depth_samples.h"
#include "scan/scan_job.h"
#include "scan/scan_session.h"

namespace scanknit {

/// Parts that are fused at once, by their numbers (from 0).
using PartGroup = std::vector<std::size_t>;

/// The first parts of `numbers`, at most `most` (> 0) of them, which need no more than the volume's part of
/// fusion.memory_budget together;
/// at least one. Each frame is then decoded once for all of them.
[[nodiscard]] PartGroup first_group(const PlannedScan& planned, const std::vector<std::size_t>& numbers,
                                    std::size_t most);

/// Reads the frames of some parts of the plan again, and writes the blocks that they make to one file for each part,
/// each all or nothing: the same bytes, whoever does it, and whatever parts are in the group. `id`: plan_id() of the
/// plan. False when a stop was requested before they were fused. Errors: kInput when the recording is not the one that
/// was planned; those of integrate_part() and write_brick_file().
[[nodiscard]] Result<bool> fuse_parts(const ScanJob& job, const PlannedScan& planned, const PartGroup& group,
                                      std::uint64_t id,
                                      const std::function<std::filesystem::path(std::size_t number)>& path_of,
                                      ScanSession& session);

/// The depth samples of the plan, read again. Errors: kInput, as above.
[[nodiscard]] Result<DepthSamples> samples_again(const ScanJob& job, const PlannedScan& planned, ScanSession& session);

}  // namespace scanknit
