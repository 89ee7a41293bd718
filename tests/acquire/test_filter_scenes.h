// Planes as a depth camera sees them, with and without what cameras do to them.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <random>

#include "core/camera.h"
#include "core/image.h"
#include "core/noise_model.h"
#include "core/rotation.h"

namespace scanknit::test {

inline const CameraIntrinsics kCamera{160, 120, 600, 600, 79.5, 59.5};

/// The normal, towards the camera, of a plane turned by `angle` about the y axis.
inline Eigen::Vector3d tilted(double angle) {
  return {std::sin(angle), 0, -std::cos(angle)};
}

/// The plane with this normal that passes through (0, 0, 0.6 m).
inline DepthImage render_plane(const Eigen::Vector3d& normal, const CameraIntrinsics& camera) {
  constexpr double kDistance_m = 0.6;
  DepthImage depth_m(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const double facing = normal.dot(camera.unproject(x, y, 1.0));
      const double z = facing < 0 ? normal.z() * kDistance_m / facing : 0;
      depth_m.at(x, y) = z > 0 && z < 20 ? static_cast<float>(z) : 0.0F;
    }
  }
  return depth_m;
}

/// Every fourth row and every fifth column without a return, as in rgbd_box_f200.
inline DepthImage with_lattice(DepthImage depth_m) {
  for (int y = 0; y < depth_m.height(); ++y) {
    for (int x = 0; x < depth_m.width(); ++x) {
      if (y % 4 == 1 || x % 5 == 2) depth_m.at(x, y) = 0;
    }
  }
  return depth_m;
}

inline DepthImage with_noise(DepthImage depth_m, const NoiseModel& noise) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  for (float& z : depth_m.pixels()) {
    if (z > 0) z = static_cast<float>(z + noise.sigma_m(z) * normal(random));
  }
  return depth_m;
}

inline double valid_pixels(const DepthImage& depth_m) {
  return static_cast<double>(
      std::count_if(depth_m.pixels().begin(), depth_m.pixels().end(), [](float z) { return z > 0; }));
}

inline double rms_difference_m(const DepthImage& a, const DepthImage& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::pow(double{a.pixels()[i]} - double{b.pixels()[i]}, 2);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

}  // namespace scanknit::test
