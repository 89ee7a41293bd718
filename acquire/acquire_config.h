// AcquireConfig: where frames come from and how their depth is cleaned. The keys of `acquire:` in YAML.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/frame_timing.h"
#include "core/limits.h"
#include "core/pose.h"

namespace scanknit {

/// Brown-Conrady lens distortion, OpenCV's order: k1 k2 p1 p2 k3.
using Distortion = std::array<double, 5>;

/// A camera as the user gives it. Width and height 0: the size of the first depth picture. Readers undistort with it.
struct CameraModel {
  CameraIntrinsics intrinsics;
  Distortion distortion{};

  friend bool operator==(const CameraModel&, const CameraModel&) = default;
};

/// The systematic error of a depth sensor, smooth over the picture and over distance:
///   1 / z = (1 + scale(u, v)) / z_measured + shift(u, v).
/// A wrong focal length or baseline is a scale, a wrong disparity a shift, which makes an error that grows as z squared
/// (Khoshelham and Elberink 2012). The fields over the picture, as CLAMS (Teichman et al. 2013), Basso et al. 2018 and
/// BAD SLAM (Schoeps et al. 2019) have them, are uniform cubic B-splines: each value is a mean of 16 of the numbers
/// below, so that bounded numbers make a bounded correction.
struct DepthBias {
  static constexpr double kMostScale = 0.1;        ///< of the absolute values of `scale`
  static constexpr double kMostShift_per_m = 0.1;  ///< of those of `shift_per_m`
  static constexpr int kFewest = 4;                ///< columns, and rows
  static constexpr int kMost = 64;

  int columns = 0, rows = 0;        ///< of numbers; the picture spans the columns - 3 by rows - 3 cells in their middle
  std::vector<double> scale;        ///< columns * rows, row by row
  std::vector<double> shift_per_m;  ///< the same
};

/// A calibrated scanner, as `calibrate camera` writes it. What is not given is as the recording or scanner says.
struct ScannerCamera {
  std::string file = {};                      ///< for messages
  std::string serial = {};                    ///< of the scanner; empty: unknown
  std::optional<CameraModel> colour = {};     ///< its distortion is that of the picture as the camera takes it
  std::optional<CameraModel> depth = {};      ///< the same
  std::optional<Pose> T_colour_depth = {};    ///< p_colour = T_colour_depth * p_depth
  std::optional<double> colour_later_s = {};  ///< FrameTiming::colour_later_s
  std::optional<DepthBias> depth_bias = {};   ///< in the straightened picture of `depth`
};

enum class RecordingFormat : int;  // acquire/recording_format.h

/// A kind of depth sensor, of which range, noise and in part the camera are known (acquire/sensor/sensor_profile.h).
enum class SensorModel {
  kNone,  ///< another one, or unknown
  kKinectV1,
  kRealsenseD400,
  kPhoneLidar,
  kTumFreiburg1,
  kTumFreiburg2,
  kTumFreiburg3
};

/// Where a frame's pose comes from.
enum class PoseMode {
  kAuto,       ///< kRecording when the recording has poses, else kTrack
  kRecording,  ///< from the recording; a frame without one is dropped
  kTrack,      ///< found from the frames; of the recording's poses only the first is used
  kRefine,     ///< the recording's, each corrected a little by tracking; frames that contradict their pose are left out
  kStill,      ///< the scanner did not move: every pose is the world's origin
};

/// True if poses are found from the frames.
[[nodiscard]] constexpr bool is_tracked(PoseMode mode) {
  return mode == PoseMode::kTrack || mode == PoseMode::kRefine;
}

/// How to use a scanner's colour.
enum class ScannerColour {
  kAuto,        ///< use it if the pose of the colour camera is known
  kRegistered,  ///< also if it is unknown: as if both cameras had the same view
  kOff,         ///< do not use it
};

/// The topics of a bag of ROS that are read; nothing: chosen by what the bag says.
struct BagTopics {
  std::optional<std::string> depth = {};          ///< pictures, or organised point clouds
  std::optional<std::string> colour = {};         ///< pictures; "none": colour is not read
  std::optional<std::string> depth_camera = {};   ///< sensor_msgs/CameraInfo
  std::optional<std::string> colour_camera = {};  ///< sensor_msgs/CameraInfo
  std::optional<std::string> poses = {};          ///< PoseStamped or PoseWithCovarianceStamped, of the depth camera

  friend bool operator==(const BagTopics&, const BagTopics&) = default;
};

/// What is known of the space that a mask leaves out.
enum class MaskMeans {
  kUnknown,  ///< nothing
  kFree,     ///< it is free up to the depth that is left out
};

/// What pictures become a volume.
enum class Geometry {
  kDepth,        ///< depth pictures are fused
  kSilhouettes,  ///< pictures from known places carve a visual hull (acquire/pictures/picture_set.h)
  kStereo,       ///< pairs of pictures of one rig are matched, and their depth is fused (acquire/stereo/stereo_rig.h)
};

struct AcquireConfig {
  Geometry geometry = Geometry::kDepth;
  RecordingFormat format{};               ///< kAuto
  std::optional<double> depth_scale;      ///< raw units per metre (1000, 5000 ...), > 0; overrides the recording's
  std::optional<CameraModel> intrinsics;  ///< of depth; overrides the recording's
  std::shared_ptr<const ScannerCamera> camera = nullptr;  ///< the same of both cameras; with `depth` no `intrinsics`
  std::optional<SensorModel> sensor;                      ///< nothing: recognised by the recording
  BagTopics topics;
  /// A folder of masks, from the pictures' folder, or kAlphaMasks; nothing: found by its name.
  std::optional<std::string> masks;
  std::optional<int> mask_class;  ///< the value of a mask's pixels that are the thing; nothing: how bright they are
  std::optional<std::string> background;  ///< a picture without the thing; masks are the difference from it
  PoseMode poses = PoseMode::kAuto;
  ScannerColour colour = ScannerColour::kAuto;
  int min_confidence = 2;  ///< phone LiDAR: 0 low, 1 medium, 2 high; depth below it is dropped
  MaskMeans mask_means = MaskMeans::kUnknown;

  std::size_t from = 0;                                      ///< first frame by its position in the recording, from 0
  std::size_t to = std::numeric_limits<std::size_t>::max();  ///< last frame, inclusive
  std::size_t every = 1;                                     ///< take every n-th frame, n >= 1

  std::optional<double> min_depth_m;     ///< nearer depth is dropped, >= 0; nothing: a scan takes the sensor's
  std::optional<double> max_depth_m;     ///< farther depth is dropped, 0: no limit; nothing: a scan chooses it
  double edge_sigmas = 3.0;              ///< depth-discontinuity mask: a step beyond this many sigma(z); 0: off
  int outlier_neighbours = 0;            ///< statistical outlier removal: number of neighbours of a point; 0: off
  double outlier_sigmas = 2.0;           ///< points whose mean distance to them is this many sigma above the mean go
  bool bilateral = false;                ///< edge-preserving smoothing of the depth
  std::optional<double> readout_s;       ///< FrameTiming::readout_s; nothing: a scan takes the sensor's
  std::optional<double> colour_later_s;  ///< FrameTiming::colour_later_s; nothing: a scan takes the sensor's
  Limits limits;

  /// Only RecordingInfo is wanted: of a large compressed bag with an index, no more is read than a description needs.
  bool only_describes = false;

  /// Masks hold several classes: depth stays whole, and frames bring their masks as Frame::labels. `mask_class` and
  /// `mask_means` are not used.
  bool keeps_labels = false;

  /// Frames bring the mask that was used as Frame::labels: 0 to 255, how much of each pixel is the thing.
  bool keeps_masks = false;

  [[nodiscard]] FrameTiming timing() const { return {readout_s.value_or(0), colour_later_s.value_or(0)}; }
};

/// Settings of a scanner before it streams; also keys of `acquire:`. Values that are not given stay as the camera has
/// them.
struct ScannerSettings {
  std::optional<bool> emitter;        ///< the projector of a pattern, on or off
  std::optional<int> laser_power_mw;  ///< of the projector
  std::optional<int> preset;          ///< by the camera's own numbering
  bool locks_exposure = true;         ///< fix colour exposure and white balance after the first second
};

}  // namespace scanknit
