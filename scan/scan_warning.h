// ScanWarning: a problem that the user should know of and that did not end the scan.
#pragma once

#include <string>

namespace scanknit {

enum class WarningCode {
  kNoEffect,          ///< a setting that changes none of the files
  kRecording,         ///< a fault of the recording as a whole
  kScanner,           ///< unknown properties of the scanner, and its failures
  kRecorder,          ///< the recorder stopped; the scan went on
  kReset,             ///< the user reset the scan
  kTrackingLost,      ///< in more than a tenth of the frames
  kLoopNotClosed,     ///< the walk came back to a place, but the mesh has the tracked poses
  kNotATurntable,     ///< no turntable was found: the mesh has the tracked poses
  kTurntable,         ///< frames or known angles that were not used
  kCropBoxIgnored,    ///< nothing lay within the live view's box
  kCropBoxDropped,    ///< the live view's box does not apply to the world of a refined turntable
  kFinishStep,        ///< a finishing step was not done, or only in part
  kNoTexture,         ///< the GLB has colours at its vertices
  kAlignment,         ///< about scans, given poses, and how they agree
  kAlignInterrupted,  ///< the mesh holds only the scans that were fused so far
  // The next ones repeat what the result has in numbers, or what the files show.
  kFramesDropped,
  kRecordingEndsEarly,
  kStoppedEarly,
  kBudgetReached,
  kPicturesLost,
  kTurntableNotTried,
  kMeshHasHoles,  ///< because of the chosen decider
  kVolumeFile,    ///< parts of a volume file were not used
  kPointsOnly,    ///< aligning only meshes and points makes no mesh
};

struct ScanWarning {
  WarningCode code;
  std::string text;  ///< for the user
};

/// "no_effect" for kNoEffect, and so on.
[[nodiscard]] const char* to_string(WarningCode code);

/// False for warnings that repeat what the result has in numbers: report.json does not list them.
[[nodiscard]] constexpr bool is_reported(WarningCode code) {
  return code < WarningCode::kFramesDropped;
}

}  // namespace scanknit
