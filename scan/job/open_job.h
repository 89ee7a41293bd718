// OpenJob: a job that was planned, and its recording. Private to the folder.
#pragma once

#include <filesystem>

#include "core/result.h"
#include "scan/bricks/planned_scan.h"
#include "scan/job/job_folder.h"
#include "scan/scan_job.h"

namespace scanknit {

struct OpenJob {
  JobFolder folder;
  ScanJob job;  ///< its configuration is complete
  PlannedScan planned;
};

/// `job`: with the configuration from config_file_of_job(); its input is not heeded. Errors: those of JobFolder, and of
/// the recording.
[[nodiscard]] Result<OpenJob> open_job(const std::filesystem::path& folder, ScanJob job);

/// A measure of the work of a brick: updates of voxels. Workers divide a job by it.
[[nodiscard]] inline double work_of(const BrickPart& part) {
  return static_cast<double>(count_frames(part.frames)) * static_cast<double>(part.most_bytes);
}

}  // namespace scanknit
