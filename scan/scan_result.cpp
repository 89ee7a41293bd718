#include "scan/scan_result.h"

#include <algorithm>

#include "export/trajectory.h"

namespace scanknit {

const char* to_string(WarningCode code) {
  switch (code) {
    case WarningCode::kNoEffect: return "no_effect";
    case WarningCode::kRecording: return "recording";
    case WarningCode::kScanner: return "scanner";
    case WarningCode::kRecorder: return "recorder";
    case WarningCode::kReset: return "reset";
    case WarningCode::kTrackingLost: return "tracking_lost";
    case WarningCode::kLostNotSearched: return "lost_not_searched";
    case WarningCode::kLoopNotClosed: return "loop_not_closed";
    case WarningCode::kNoTurntable: return "no_turntable";
    case WarningCode::kTurntable: return "turntable";
    case WarningCode::kCropBoxIgnored: return "crop_box_ignored";
    case WarningCode::kCropBoxDropped: return "crop_box_dropped";
    case WarningCode::kFinishStep: return "finish_step";
    case WarningCode::kNoTexture: return "no_texture";
    case WarningCode::kAlignment: return "alignment";
    case WarningCode::kAlignInterrupted: return "align_interrupted";
    case WarningCode::kFramesDropped: return "frames_dropped";
    case WarningCode::kRecordingEndsEarly: return "recording_ends_early";
    case WarningCode::kStoppedEarly: return "stopped_early";
    case WarningCode::kBudgetReached: return "budget_reached";
    case WarningCode::kPicturesLost: return "pictures_lost";
    case WarningCode::kTurntableNotTried: return "turntable_not_tried";
    case WarningCode::kMeshHasHoles: return "mesh_has_holes";
    case WarningCode::kVolumeFile: return "volume_file";
    case WarningCode::kSilhouettes: return "silhouettes";
    case WarningCode::kPointsOnly: return "points_only";
    case WarningCode::kClasses: return "classes";
  }
  return "";
}

const char* to_string(FinishStep step) {
  switch (step) {
    case FinishStep::kCrop: return "crop";
    case FinishStep::kGround: return "ground";
    case FinishStep::kWatertight: return "watertight";
    case FinishStep::kPieces: return "pieces";
    case FinishStep::kCrumbs: return "crumbs";
    case FinishStep::kSmooth: return "smooth";
    case FinishStep::kSimplify: return "simplify";
    case FinishStep::kPlace: return "place";
  }
  return "";
}

const char* to_string(AlignKind kind) {
  switch (kind) {
    case AlignKind::kRange: return "range scan";
    case AlignKind::kRecording: return "recording";
    case AlignKind::kMesh: return "mesh";
    case AlignKind::kCloud: return "point cloud";
  }
  return "";
}

std::vector<StampedPose> stamped_poses(const Trajectory& trajectory) {
  std::vector<StampedPose> poses;
  poses.reserve(trajectory.size());
  for (const PosedFrame& frame : trajectory) poses.push_back({frame.stamp, frame.T_world_camera});
  return poses;
}

const ScanWarning* find_warning(const ScanResult& result, WarningCode code) {
  const auto found = std::find_if(result.warnings.begin(), result.warnings.end(),
                                  [&](const ScanWarning& warning) { return warning.code == code; });
  return found == result.warnings.end() ? nullptr : &*found;
}

}  // namespace scanknit
