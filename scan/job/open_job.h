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

/// Divides bricks, one after the other, into shares with about so much work; 0: each is a share.
class WorkPlace {
 public:
  explicit WorkPlace(double share_work) : share_work_(share_work) {}
  /// The share, from 0, in which the middle of the next brick is.
  [[nodiscard]] std::size_t share_of(const BrickPart& next) const {
    return share_work_ > 0 ? static_cast<std::size_t>((work_ + work_of(next) / 2) / share_work_) : bricks_;
  }
  void pass(const BrickPart& brick) {
    work_ += work_of(brick);
    ++bricks_;
  }

 private:
  double share_work_, work_ = 0;
  std::size_t bricks_ = 0;
};

}  // namespace scanknit
