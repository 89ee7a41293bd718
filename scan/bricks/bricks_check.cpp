#include "scan/bricks/bricks_check.h"

#include <string>

namespace scanknit {
namespace {

/// Nothing: all of it can be done.
const char* needs_whole_volume(const ScanJob& job, PoseMode poses) {
  const FinishConfig& finish = job.config.finish;
  if (job.config.turntable.is_enabled) return "a turntable is looked for (turntable.enabled)";
  if (is_tracked(poses)) return "poses are tracked (acquire.poses)";
  if (job.pace != Pace::kFast) return "frames come at the pace of the recording";
  if (job.files.volume) return "the volume's .vdb file is asked for";
  if (job.config.fusion.silhouettes != SilhouetteUse::kOff) return "masks fill what depth left (fusion.silhouettes)";
  if (finish.crop.is_set()) return "the volume is cropped (finish.crop)";
  if (finish.watertight != Watertight::kOff) return "holes are closed (finish.watertight)";
  if (finish.needs_plane()) return "the ground is looked for (finish.ground, finish.up)";
  if (is_tetrahedral(job.config.extract.decider)) return "extract.decider is one of the tetrahedral ones";
  return nullptr;
}

}  // namespace

Result<void> check_bricks(const ScanJob& job, PoseMode poses) {
  const char* const reason = needs_whole_volume(job, poses);
  if (reason == nullptr) return {};
  return Error{ErrorCode::kUsage, std::string("it cannot be fused in bricks because ") + reason};
}

Result<void> check_coarse_bricks(const ScanJob& job, PoseMode poses) {
  ScanJob open = job;
  open.config.finish.watertight = Watertight::kOff;
  return check_bricks(open, poses);
}

}  // namespace scanknit
