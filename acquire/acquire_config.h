// AcquireConfig: where frames come from and how their depth is cleaned. The keys of `acquire:` in YAML.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>

#include "core/camera.h"
#include "core/limits.h"

namespace scanknit {

/// Brown-Conrady lens distortion, OpenCV's order: k1 k2 p1 p2 k3.
using Distortion = std::array<double, 5>;

/// A camera as a user states it. Width and height 0: the size of the first depth picture. Readers undistort with it.
struct CameraModel {
  CameraIntrinsics intrinsics;
  Distortion distortion{};
};

/// How a recording is laid out (docs/recordings.md).
enum class RecordingFormat {
  kAuto,  ///< by its content
  kSevenScenes,
  kTum,
  kOpen3d,
  kPhoneLidar,
  kPcd,
  kPclzf,
  kFakenect,
  kMcap,
  kRealsenseBag,
  kOni
};

/// Where a frame's pose comes from.
enum class PoseMode {
  kAuto,       ///< kRecording when the recording has poses, else kTrack
  kRecording,  ///< from the recording; a frame without one is dropped
  kTrack,      ///< found from what the frames show; the recording's are not looked at but for the first
  kRefine,  ///< the recording's, each corrected a little by what the frame shows, or left out where that contradicts it
  kStill,   ///< the scanner did not move: every frame is seen from the world's origin
};

/// True where poses are found from the frames.
[[nodiscard]] constexpr bool is_tracked(PoseMode mode) {
  return mode == PoseMode::kTrack || mode == PoseMode::kRefine;
}

/// What becomes of a scanner's colour.
enum class ScannerColour {
  kAuto,        ///< used where it is known where the colour camera is, else left out
  kRegistered,  ///< ... else taken to see what the depth camera sees
  kOff,         ///< left out
};

struct AcquireConfig {
  RecordingFormat format = RecordingFormat::kAuto;
  std::optional<double> depth_scale;      ///< raw units per metre (1000, 5000 ...), > 0; overrides the recording's
  std::optional<CameraModel> intrinsics;  ///< overrides the recording's
  PoseMode poses = PoseMode::kAuto;
  ScannerColour colour = ScannerColour::kAuto;
  int min_confidence = 2;  ///< phone LiDAR: 0 low, 1 medium, 2 high; depth below it is dropped

  std::size_t from = 0;  ///< first frame by its place in the recording, counting from 0
  std::size_t to = std::numeric_limits<std::size_t>::max();  ///< last frame, included
  std::size_t every = 1;                                     ///< take every n-th frame, n >= 1

  double min_depth_m = 0.0;     ///< nearer depth is dropped; >= 0
  double max_depth_m = 0.0;     ///< farther depth is dropped; 0: no limit
  double edge_sigmas = 3.0;     ///< depth-discontinuity mask: a step beyond this many sigma(z); 0: off
  int outlier_neighbours = 0;   ///< statistical outlier removal: neighbours of a point that are looked at; 0: off
  double outlier_sigmas = 2.0;  ///< points whose mean distance to them is this many sigma above the mean are dropped
  bool bilateral = false;       ///< edge-preserving smoothing of the depth
  Limits limits;
};

/// What a scanner is told before it streams; also keys of `acquire:`. What is not given is left as the camera has it.
struct ScannerSettings {
  std::optional<bool> emitter;        ///< the projector of a pattern, on or off
  std::optional<int> laser_power_mw;  ///< of the projector
  std::optional<int> preset;          ///< by the camera's own numbering
  bool locks_exposure = true;         ///< colour exposure and white balance are held after the first second
};

}  // namespace scanknit
