#include "synth/view_camera.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/check.h"

namespace scanknit {

ViewCamera::ViewCamera(const CameraIntrinsics& intrinsics, const Pose& T_world_camera)
    : ViewCamera(intrinsics, RadialLens{}, {T_world_camera}) {}

ViewCamera::ViewCamera(const CameraIntrinsics& intrinsics, const RadialLens& lens, std::vector<Pose> band_poses)
    : intrinsics_(intrinsics), lens_(lens), poses_(std::move(band_poses)) {
  SCANKNIT_CHECK(!poses_.empty() && poses_.size() <= static_cast<std::size_t>(std::max(1, intrinsics.height)));
  inverses_.reserve(poses_.size());
  for (const Pose& pose : poses_) inverses_.push_back(pose.inverse());
}

std::size_t ViewCamera::band_of(double row) const {
  const double share = std::clamp((row + 0.5) / intrinsics_.height, 0.0, 1.0);
  return std::min(static_cast<std::size_t>(share * static_cast<double>(poses_.size())), poses_.size() - 1);
}

// The lens' polynomial has no closed inverse: a fixed point, which converges because the terms are small.
Eigen::Vector3d ViewCamera::through(int x, int y) const {
  const Eigen::Vector3d seen = intrinsics_.unproject(x, y, 1.0);
  if (lens_ == RadialLens{}) return seen;
  constexpr int kSteps = 12;
  Eigen::Vector2d ideal = seen.head<2>();
  for (int step = 0; step < kSteps; ++step) {
    const double r2 = ideal.squaredNorm();
    ideal = seen.head<2>() / (1 + r2 * (lens_.k1 + r2 * lens_.k2));
  }
  return {ideal.x(), ideal.y(), 1.0};
}

Eigen::Vector2d ViewCamera::pixel_of(const Eigen::Vector3d& p_camera) const {
  if (lens_ == RadialLens{}) return intrinsics_.project(p_camera);
  constexpr double kWidest = 4;  // 63 degrees off the axis; farther out the polynomial would fold back into the picture
  const double r2 = std::min(kWidest, p_camera.head<2>().squaredNorm() / (p_camera.z() * p_camera.z()));
  const double stretch = 1 + r2 * (lens_.k1 + r2 * lens_.k2);
  return intrinsics_.project({stretch * p_camera.x(), stretch * p_camera.y(), p_camera.z()});
}

// The band that sees a point depends on the row where it is seen: three steps suffice, since a camera moves by less
// than a band while a band is read.
std::optional<Sighting> ViewCamera::see(const Eigen::Vector3d& p_world) const {
  const int steps = poses_.size() == 1 ? 1 : 3;
  std::size_t band = poses_.size() / 2;
  Sighting sighting;
  for (int step = 0; step < steps; ++step) {
    const Pose& T_camera_world = inverses_[band];
    sighting.p_camera = T_camera_world * p_world;
    if (!(sighting.p_camera.z() > 0)) return std::nullopt;
    sighting.pixel = pixel_of(sighting.p_camera);
    sighting.R_camera_world = T_camera_world.linear();
    band = band_of(sighting.pixel.y());
  }
  return sighting;
}

}  // namespace scanknit
