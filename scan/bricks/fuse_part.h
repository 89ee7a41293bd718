// fuse_part: fuses one part of a planned scan into a file.
#pragma once

#include <cstddef>
#include <filesystem>

#include "core/result.h"
#include "scan/bricks/planned_scan.h"
#include "scan/frames/depth_samples.h"
#include "scan/scan_job.h"
#include "scan/scan_session.h"

namespace scanknit {

/// Reads the frames of planned.parts[number] again, and writes the blocks that they make to `path`, all or nothing: the
/// same bytes, whoever does it. `id`: plan_id() of the plan. False when a stop was requested before it was whole.
/// Errors: kInput when the recording is not the one that was planned; those of integrate_part() and write_brick_file().
[[nodiscard]] Result<bool> fuse_part(const ScanJob& job, const PlannedScan& planned, std::size_t number,
                                     std::uint64_t id, const std::filesystem::path& path, ScanSession& session);

/// The depth samples that plan_parts() would have given, read again. Errors: kInput, as above.
[[nodiscard]] Result<DepthSamples> samples_again(const ScanJob& job, const PlannedScan& planned, ScanSession& session);

}  // namespace scanknit
