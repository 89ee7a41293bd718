// Texture: procedural colour with detail at every scale, so that photometric tracking works.
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace scanknit {

enum class Pattern { kChecks, kStripes, kMarble };

/// sRGB colours in [0, 1].
struct Texture {
  Eigen::Vector3d dark = Eigen::Vector3d(0.25, 0.25, 0.3);
  Eigen::Vector3d light = Eigen::Vector3d(0.85, 0.8, 0.75);
  Pattern pattern = Pattern::kChecks;
  double period_m = 0.02;  ///< side of a check, half a stripe, size of a vein
};

/// The colour at a point in the solid's own frame; each channel in [0, 1].
[[nodiscard]] Eigen::Vector3d texture_colour(const Texture& texture, const Eigen::Vector3d& p_solid);

/// Smooth noise in [0, 1] with features of about 1 (value noise on the integer lattice).
[[nodiscard]] double smooth_noise(const Eigen::Vector3d& p);

}  // namespace scanknit
