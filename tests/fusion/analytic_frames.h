// Noise-free frames of a plane and of a sphere, rendered in closed form.
#pragma once

#include <cmath>
#include <optional>

#include "core/frame.h"

namespace scanknit::test {

inline CameraIntrinsics small_camera() {
  return {160, 120, 130, 130, 79.5, 59.5};
}

/// Depth along each pixel's ray as `z_along(ray)` gives it for ray = (x, y, 1); nothing = no return.
template <typename ZAlongRay>
Frame render(const CameraIntrinsics& camera, ZAlongRay z_along) {
  Frame frame;
  frame.intrinsics = camera;
  frame.depth_m = DepthImage(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const std::optional<double> z = z_along(camera.unproject(x, y, 1.0));
      if (z) frame.depth_m.at(x, y) = static_cast<float>(*z);
    }
  }
  return frame;
}

/// The plane normal . p = offset (camera frame), with its exact normals.
inline Frame plane_frame(const CameraIntrinsics& camera, const Eigen::Vector3d& normal, double offset_m) {
  Frame frame = render(camera, [&](const Eigen::Vector3d& ray) -> std::optional<double> {
    const double slope = normal.dot(ray);
    if (slope == 0 || offset_m / slope <= 0) return std::nullopt;
    return offset_m / slope;
  });
  const Eigen::Vector3d towards_camera = offset_m > 0 ? Eigen::Vector3d(-normal) : normal;
  frame.normals = Image<Eigen::Vector3f>(camera.width, camera.height, towards_camera.normalized().cast<float>());
  return frame;
}

/// A sphere (camera frame), with its exact normals.
inline Frame sphere_frame(const CameraIntrinsics& camera, const Eigen::Vector3d& centre, double radius_m) {
  Frame frame = render(camera, [&](const Eigen::Vector3d& ray) -> std::optional<double> {
    const double a = ray.squaredNorm();
    const double b = ray.dot(centre);
    const double discriminant = b * b - a * (centre.squaredNorm() - radius_m * radius_m);
    if (discriminant < 0) return std::nullopt;
    return (b - std::sqrt(discriminant)) / a;
  });
  frame.normals = Image<Eigen::Vector3f>(camera.width, camera.height, Eigen::Vector3f::Zero());
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const double z = static_cast<double>(frame.depth_m.at(x, y));
      if (z > 0) frame.normals.at(x, y) = (camera.unproject(x, y, z) - centre).normalized().cast<float>();
    }
  }
  return frame;
}

/// A camera at `eye` that looks at the origin.
inline Pose looking_at_origin(const Eigen::Vector3d& eye) {
  const Eigen::Vector3d forward = -eye.normalized();
  const Eigen::Vector3d right = Eigen::Vector3d(0, 0, 1).cross(forward).squaredNorm() > 1e-6
                                    ? Eigen::Vector3d(0, 0, 1).cross(forward).normalized()
                                    : Eigen::Vector3d::UnitX();
  Pose pose = Pose::Identity();
  pose.linear().col(0) = right;
  pose.linear().col(1) = forward.cross(right);
  pose.linear().col(2) = forward;
  pose.translation() = eye;
  return pose;
}

}  // namespace scanknit::test
