// A scan in bricks by several processes, on one machine or on many: plan_job, work_on_job, join_job, job_status.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>

#include "core/result.h"
#include "scan/scan_job.h"
#include "scan/scan_observer.h"
#include "scan/scan_result.h"

namespace scanknit {

/// A job is a folder, and nothing else. It may be moved, alone or together with the recording.
///   plan            what there is to do: PlannedScan, the recording's place, hashes
///   config.yaml     the configuration
///   bricks/N.brick  what is done, from 0
///   claims/N.claim  what a worker is at (BrickClaim)
[[nodiscard]] std::filesystem::path config_file_of_job(const std::filesystem::path& folder);

struct PlanRequest {
  ScanJob job;                                      ///< of its files, none is written
  std::string yaml;                                 ///< job.config as text, for config.yaml
  std::optional<std::filesystem::path> trajectory;  ///< the frames' poses (TrajectoryFile), instead of the recording's
};

/// Makes the folder, whole or not at all. Poses that are to be tracked are tracked here: the plan has them. Returns the
/// number of bricks. Errors: those of scan_recording(); kUsage when it cannot be fused in bricks; kOutput when the
/// folder exists and is not empty.
[[nodiscard]] Result<std::size_t> plan_job(const PlanRequest& request, const std::filesystem::path& folder,
                                           ScanObserver& observer, std::stop_token stop = {});

struct WorkRequest {
  std::optional<std::size_t> brick;  ///< only this one (from 0), which is made anew if any of its bytes is wrong
  std::size_t workers = 0;           ///< about so many share the job; 0: unknown
};

struct JobWork {
  std::size_t fused = 0;      ///< bricks that this worker made
  std::size_t elsewhere = 0;  ///< bricks that other workers are at
  bool is_stopped = false;    ///< by the stop token
};

/// Fuses one brick after the other, except those that are done and those that another worker is at. Knowing the number
/// of workers, takes its share of the bricks at once, as far as the memory budget allows: a frame is decoded once for
/// all of them. `config`: that of config_file_of_job(). Errors: kConfig for a job of another version or configuration;
/// kInput for a folder that is no job, and for a recording that has changed; kUsage for a brick that the job does not
/// have; kOutput.
[[nodiscard]] Result<JobWork> work_on_job(const std::filesystem::path& folder, const ScanConfig& config,
                                          const WorkRequest& request, ScanObserver& observer,
                                          std::stop_token stop = {});

/// The files of `job`, whose input is not heeded, as scan_recording() would write them. ScanResult::outcome: errors of
/// work_on_job(); kInput when bricks are missing or damaged; kUsage when a file of the job needs the whole volume.
[[nodiscard]] ScanResult join_job(const std::filesystem::path& folder, const ScanJob& job, ScanObserver& observer,
                                  std::stop_token stop = {});

struct JobStatus {
  std::string recording;
  std::size_t bricks = 0, done = 0;
  std::size_t in_work = 0;  ///< a worker is at them
  std::size_t free = 0;     ///< not begun, or left by a worker that died
  std::size_t torn = 0;     ///< of `free`: there is a file that is not whole
};

enum class BrickCheck {
  kNames,  ///< bricks whose files are there are done: they appear whole
  kEnds,   ///< opens each file: torn ones are found
};

/// Errors: kInput for a folder that is no job; kConfig for one of another version.
[[nodiscard]] Result<JobStatus> job_status(const std::filesystem::path& folder, BrickCheck check);

}  // namespace scanknit
