// SynthConfig: how a synthetic scene is scanned.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/camera.h"
#include "core/result.h"
#include "synth/noise.h"
#include "synth/turntable_rig.h"

namespace scanknit {

struct SynthConfig {
  int frames = 0;  ///< poses along the scene's path; 0: the scene's default
  int stills = 1;  ///< pictures taken from each pose (they differ by their noise only)
  CameraIntrinsics intrinsics{640, 480, 525.0, 525.0, 319.5, 239.5};
  bool noise = false;
  KinectNoise noise_model;
  std::uint64_t seed = 1;  ///< of the noise, of a turntable's angles and of the truth points
  /// The camera stands still and the scene turns on a table: its path is not looked at, its frames are, 120 by default.
  std::optional<RigConfig> turntable = std::nullopt;
  double depth_scale = 10'000;         ///< raw units per metre of the depth pictures: 0.1 mm, up to 6.5 m
  bool jpeg_colour = false;            ///< colour as JPEG of quality 95 instead of PNG
  std::size_t truth_points = 200'000;  ///< sampled on the surface; those that are seen are written
  int min_views = 3;                   ///< a truth point counts as visible when this many frames see it
};

/// Error kConfig names the field, its value and what was expected.
[[nodiscard]] Result<void> validate(const SynthConfig& config);

}  // namespace scanknit
