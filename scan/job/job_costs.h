// JobCosts: what the steps of a job take here, measured with some of its bricks. Private to the folder.
#pragma once

#include <cstddef>
#include <filesystem>

#include "core/result.h"
#include "scan/job/open_job.h"
#include "scan/scan_session.h"

namespace scanknit {

/// Seconds are those of a processor: of all threads together, without waiting.
struct JobCosts {
  double plan_s = 0;              ///< of the whole plan
  double start_s = 0;             ///< to start a process and to open the job
  double frame_s = 0;             ///< to read, filter and look through a frame
  double update_s = 0;            ///< to fuse a frame into a block that the plan gives to its brick, writing included
  double join_start_s = 0;        ///< of a join, whatever the size of the surface
  double join_s_per_byte = 0;     ///< of brick files
  double frame_bytes = 0;         ///< of the recording
  double bytes_per_block = 0;     ///< of brick files, for a block that the plan gives to a brick
  double triangles_per_byte = 0;  ///< of brick files
  double process_mib = 0;         ///< resident, without a volume
  double memory_per_block = 0;    ///< of a volume, for a block that the plan gives to a brick
  std::size_t sampled = 0;        ///< bricks that were fused to know
};

/// The blocks of a part that some frame may observe.
[[nodiscard]] std::size_t planned_blocks(const BrickPart& part);

/// Reads some frames, fuses and joins some bricks. `join`: as for join_job(); its files are written, and should be in
/// `scratch`, a folder for brick files. Leaves plan_s and start_s. Errors: those of work_on_job() and join_job().
[[nodiscard]] Result<JobCosts> measure_costs(const OpenJob& job, const ScanJob& join,
                                             const std::filesystem::path& scratch, ScanSession& session);

}  // namespace scanknit
