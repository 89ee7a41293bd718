// ScanWarning: what a person should know of a scan that went on all the same.
#pragma once

#include <string>

namespace scanknit {

enum class WarningCode {
  kNoEffect,          ///< a setting that cannot change any of the files
  kRecording,         ///< the recording as a whole has a fault
  kScanner,           ///< what the scanner does not tell, and what happened to it
  kRecorder,          ///< the recorder stopped; the scan went on
  kBegunAnew,         ///< a person reset the scan
  kTrackingLost,      ///< in more than a tenth of the frames
  kLoopNotClosed,     ///< the walk came back, and the mesh is as tracked
  kNotATurntable,     ///< the mesh is the tracked one
  kTurntable,         ///< frames that were left out, angles that were not used
  kCropBoxIgnored,    ///< nothing lay within the live view's box
  kCropBoxDropped,    ///< a refined turntable has another world than the live view's box
  kFinishStep,        ///< a step of finishing was not done, or not all of it
  kNoTexture,         ///< the GLB has colours at its vertices
  kAlignment,         ///< of scans, of the poses that were given, and of how they agree
  kAlignInterrupted,  ///< the mesh holds only the scans that were fused so far
  // The next ones say in words what the result has in numbers, or what a person sees from the files.
  kFramesDropped,
  kRecordingEndsEarly,
  kStoppedEarly,
  kBudgetReached,
  kPicturesLost,
  kTurntableNotTried,
  kMeshHasHoles,  ///< by the chosen decider
  kVolumeFile,    ///< parts of a volume file that were left out
  kPointsOnly,    ///< an alignment of meshes and points makes no mesh
};

struct ScanWarning {
  WarningCode code;
  std::string text;  ///< for people
};

/// False for warnings that repeat in words what the result has in numbers: report.json leaves them out.
[[nodiscard]] constexpr bool is_reported(WarningCode code) {
  return code < WarningCode::kFramesDropped;
}

}  // namespace scanknit
