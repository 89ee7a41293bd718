// SensorProfile: what is known of a kind of depth sensor, so that nobody has to say it. The presets of the same names,
// and docs/configuration.md, have these numbers from here.
#pragma once

#include <algorithm>
#include <array>
#include <optional>

#include "acquire/acquire_config.h"
#include "core/noise_model.h"

namespace scanknit {

/// Where no acquire.max_depth is given, depth ends where sigma(z) exceeds so many voxels: farther away, a frame tells
/// little of what the voxels could show.
inline constexpr int kMostNoiseVoxels = 5;

struct SensorProfile {
  SensorModel model = SensorModel::kNone;
  const char* name = "";  ///< the word of acquire.sensor
  const char* what = "";  ///< the products, or the data set
  double min_depth_m = 0, max_depth_m = 0;
  NoiseModel noise;
  FrameTiming timing = {};
  std::optional<CameraModel> camera = {};  ///< of a data set whose recordings do not state their one camera
};

// Nguyen, Izadi, Lovell 2012, "Modeling Kinect Sensor Noise for Improved 3D Reconstruction and Tracking", eq. (1).
inline constexpr NoiseModel kKinectNoise = {.floor_m = 0.0012, .growth_per_m = 0.0019, .from_m = 0.4};

// Ringaby & Forssén 2011, "Scan rectification for structured light range sensors with rolling shutters": the infrared
// camera reads its rows in 30.55 ms. The two cameras have clocks of their own; 10 ms is the middle of what fitted one
// recording about equally (docs/fusion.md, "A camera that moves while it takes a frame"). An Xtion and a Carmine have
// the Kinect's chip; that they have its timing is assumed.
inline constexpr FrameTiming kKinectTiming = {.readout_s = 0.03055, .colour_later_s = 0.010};

// Stereo: sigma = z^2 subpixel / (f baseline). A D435 with a subpixel error of 0.08, f = 390 pixels at 848 x 480 and a
// baseline of 50 mm: 0.0041 z^2.
inline constexpr NoiseModel kStereoNoise = {.floor_m = 0.001, .growth_per_m = 0.0041, .from_m = 0};

// Dense and smooth; its error is about 1 % of the distance.
inline constexpr NoiseModel kPhoneNoise = {.floor_m = 0.01, .growth_per_m = 0.001, .from_m = 0.5};

// Sturm et al. 2012; intrinsics and distortion from the data set's page. freiburg3 is undistorted already.
inline constexpr CameraModel kFreiburg1 = {{640, 480, 517.3, 516.5, 318.6, 255.3},
                                           {0.2624, -0.9531, -0.0054, 0.0026, 1.1633}};
inline constexpr CameraModel kFreiburg2 = {{640, 480, 520.9, 521.0, 325.1, 249.7},
                                           {0.2312, -0.7849, -0.0033, -0.0001, 0.9172}};
inline constexpr CameraModel kFreiburg3 = {{640, 480, 535.4, 539.2, 320.1, 247.6}, {}};

/// In the order of SensorModel. A Kinect's range ends at 4 m: beyond, one step of its disparity is more than 4 cm.
inline constexpr std::array kSensorProfiles = {
    SensorProfile{SensorModel::kKinectV1, "kinect_v1",
                  "Kinect for Xbox 360, Asus Xtion, PrimeSense Carmine (Nguyen et al. 2012)", 0.5, 4, kKinectNoise,
                  kKinectTiming},
    SensorProfile{SensorModel::kRealsenseD400, "realsense_d400", "Intel RealSense D415, D435, D455", 0.3, 4,
                  kStereoNoise},
    SensorProfile{SensorModel::kPhoneLidar, "phone_lidar", "LiDAR of phones and tablets (ARKit exports)", 0, 5,
                  kPhoneNoise},
    SensorProfile{SensorModel::kTumFreiburg1, "tum_freiburg1", "TUM RGB-D, sequences freiburg1_*, with their camera",
                  0.5, 4, kKinectNoise, kKinectTiming, kFreiburg1},
    SensorProfile{SensorModel::kTumFreiburg2, "tum_freiburg2", "TUM RGB-D, sequences freiburg2_*, with their camera",
                  0.5, 4, kKinectNoise, kKinectTiming, kFreiburg2},
    SensorProfile{SensorModel::kTumFreiburg3, "tum_freiburg3", "TUM RGB-D, sequences freiburg3_*, with their camera",
                  0.5, 4, kKinectNoise, kKinectTiming, kFreiburg3}};

/// Null for kNone.
[[nodiscard]] inline const SensorProfile* find_sensor(SensorModel model) {
  const auto* found = std::find_if(kSensorProfiles.begin(), kSensorProfiles.end(),
                                   [&](const SensorProfile& profile) { return profile.model == model; });
  return found == kSensorProfiles.end() ? nullptr : found;
}

}  // namespace scanknit
