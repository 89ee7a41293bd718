// JobEstimate: what a planned job will take.
#pragma once

#include <cstddef>
#include <filesystem>
#include <stop_token>
#include <vector>

#include "core/result.h"
#include "scan/bricks/planned_scan.h"
#include "scan/scan_job.h"
#include "scan/scan_observer.h"

namespace scanknit {

struct JobCosts;

/// Seconds are those of a processor: of all threads together, without waiting. Bytes of a frame are those of the
/// recording; of a brick, those of its file.
struct JobEstimate {
  struct Cost {
    double s = 0, bytes = 0;
  };
  struct Brick {
    std::size_t frames = 0, blocks = 0;  ///< that may change it; that may be in it
    double s = 0, bytes = 0;             ///< made alone
  };

  std::size_t workers = 1;  ///< of what follows; each has a processor, and storage does not hold it up
  double plan_s = 0, work_s = 0, join_s = 0;
  double wall_s = 0;                    ///< plan, the worker that takes longest, and join; a processor for each process
  double worker_mib = 0, join_mib = 0;  ///< resident, the largest
  double folder_bytes = 0;              ///< of the job, when all bricks are done
  double triangles = 0;                 ///< of the mesh, about

  Cost start;       ///< of a process of the job
  Cost frame;       ///< each time that it is read
  Cost brick;       ///< beside its frames, mean
  Cost seam;        ///< mean, if bricks are made one by one: frames that are read anew, as they meet both sides
  Cost join_start;  ///< of join, whatever the size of the mesh
  double join_s_per_byte = 0;  ///< of brick files, beside that
  std::size_t frames = 0, seams = 0;
  std::size_t sampled = 0;  ///< bricks that were fused to know
  std::vector<Brick> bricks;
};

/// The estimate for so many workers, each of which knows how many there are; 0: they do not, and take single bricks.
[[nodiscard]] JobEstimate estimate(const PlannedScan& planned, const JobCosts& costs, std::size_t workers);

/// What this process spent so far.
[[nodiscard]] double processor_seconds();

struct EstimateRequest {
  ScanJob join;                   ///< as for join_job(), but its files are to be in a folder of no further use
  std::filesystem::path scratch;  ///< such a folder, for some bricks
  std::size_t workers = 1;
  double plan_s = 0;     ///< processor seconds that this process took until the job was planned
  double process_s = 0;  ///< of them, to start the process
};

/// Measures what some frames and bricks of the job take on this machine: about forty of its frames, and an eighth of
/// its bricks, 3 to 16. Errors: those of work_on_job() and join_job(); kInput when a stop was requested.
[[nodiscard]] Result<JobEstimate> estimate_job(const std::filesystem::path& folder, const EstimateRequest& request,
                                               ScanObserver& observer, std::stop_token stop = {});

}  // namespace scanknit
