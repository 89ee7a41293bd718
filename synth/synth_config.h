// SynthConfig: how to scan a synthetic scene.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/camera.h"
#include "core/result.h"
#include "synth/noise.h"
#include "synth/path/path_names.h"
#include "synth/path/recorded_motion.h"
#include "synth/scene/person_names.h"
#include "synth/sensor/rendered_sensor.h"
#include "synth/turntable_rig.h"

namespace scanknit {

struct SynthConfig {
  int frames = 0;  ///< poses along the scene's path; 0: the scene's default
  int stills = 1;  ///< pictures from each pose (only their noise differs)
  CameraIntrinsics intrinsics{640, 480, 525.0, 525.0, 319.5, 239.5};
  bool noise = false;
  KinectNoise noise_model;
  /// If set, the pictures are this sensor's, at its own pace, with time stamps; `noise` must be false. `intrinsics` are
  /// those that the camera has; the recording states what the sensor believes.
  std::optional<RenderedSensor> sensor = std::nullopt;
  PathKind path = PathKind::kScene;
  std::vector<PathPose> recorded_path = {};  ///< if not empty, flown from where the scene's path begins
  PersonKind person = PersonKind::kNobody;
  std::uint64_t seed = 1;  ///< for the noise, the hand, a turntable's angles and the truth points
  /// If set, the camera stands still and the scene turns on a table. Ignores the scene's path; uses `frames`, 120 by
  /// default.
  std::optional<RigConfig> turntable = std::nullopt;
  double depth_scale = 10'000;         ///< raw units per metre of the depth pictures: 0.1 mm, up to 6.5 m
  bool jpeg_colour = false;            ///< colour as JPEG of quality 95 instead of PNG
  bool masks = false;                  ///< masks/NNNNNN.png, too: white where a faultless camera sees a surface
  std::size_t truth_points = 200'000;  ///< number sampled on the surface; only the visible ones are written
  int min_views = 3;                   ///< a truth point counts as visible when this many frames see it
};

/// The camera that the recording states: the sensor's belief, or the true one.
[[nodiscard]] CameraIntrinsics stated_camera(const SynthConfig& config);

/// Raw units per metre of the recording's depth pictures: the sensor's, or config.depth_scale.
[[nodiscard]] double units_per_metre(const SynthConfig& config);

/// Error kConfig names the field, its value and what was expected.
[[nodiscard]] Result<void> validate(const SynthConfig& config);

}  // namespace scanknit
