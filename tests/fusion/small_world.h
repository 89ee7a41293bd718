// A small room with two balls in it, known exactly: frames from any place, with or without colour.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "core/frame_timing.h"
#include "fusion/register/model_view.h"
#include "tests/fusion/analytic_frames.h"

namespace scanknit::test {

inline constexpr double kPi = 3.14159265358979323846;

/// What a ray meets first.
struct Met {
  double t;  ///< along the ray
  Eigen::Vector3d p_world, normal;
};

/// Anything that a ray can meet.
class World {
 public:
  /// The half space normal . p < offset is matter.
  World& add_wall(const Eigen::Vector3d& normal, double offset_m) {
    walls_.push_back({normal.normalized(), offset_m});
    return *this;
  }
  World& add_ball(const Eigen::Vector3d& centre, double radius_m) {
    balls_.push_back({centre, radius_m});
    return *this;
  }

  [[nodiscard]] std::optional<Met> meet(const Eigen::Vector3d& eye, const Eigen::Vector3d& ray) const {
    std::optional<Met> nearest;
    const auto keep = [&](double t, const Eigen::Vector3d& normal) {
      if (t > 0 && (!nearest || t < nearest->t)) nearest = Met{t, eye + t * ray, normal};
    };
    for (const Wall& wall : walls_) {
      const double slope = wall.normal.dot(ray);
      if (slope < 0) keep((wall.offset_m - wall.normal.dot(eye)) / slope, wall.normal);
    }
    for (const Ball& ball : balls_) {
      const Eigen::Vector3d to_eye = eye - ball.centre;
      const double a = ray.squaredNorm();
      const double b = ray.dot(to_eye);
      const double discriminant = b * b - a * (to_eye.squaredNorm() - ball.radius_m * ball.radius_m);
      if (discriminant < 0) continue;
      const double t = (-b - std::sqrt(discriminant)) / a;
      keep(t, (to_eye + t * ray).normalized());
    }
    return nearest;
  }

  /// A smooth pattern without repetition within a metre, 0 to 1.
  [[nodiscard]] static double intensity(const Eigen::Vector3d& p) {
    return 0.5 + 0.2 * std::sin(17 * p.x() + 5 * p.y()) + 0.15 * std::sin(23 * p.y() - 7 * p.z()) +
           0.15 * std::sin(19 * p.z() + 11 * p.x());
  }

 private:
  struct Wall {
    Eigen::Vector3d normal;
    double offset_m;
  };
  struct Ball {
    Eigen::Vector3d centre;
    double radius_m;
  };
  std::vector<Wall> walls_;
  std::vector<Ball> balls_;
};

/// 3 x 2.4 x 3 m, the balls near its middle.
inline World small_room() {
  World room;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d normal = Eigen::Vector3d::Unit(axis);
    const double half_m = axis == 1 ? 1.2 : 1.5;
    room.add_wall(normal, -half_m).add_wall(-normal, -half_m);
  }
  return room.add_ball({0.1, -0.1, 0.0}, 0.3).add_ball({-0.35, 0.1, 0.3}, 0.2);
}

inline World bare_wall() {
  return World().add_wall({0, 0, -1}, -1.0);
}

/// The frame seen from there, with exact normals. `rows`: the camera's motion while it reads the rows.
inline Frame look(const World& world, const Pose& T_world_camera, bool has_colour = true,
                  const CameraIntrinsics& camera = small_camera(), const SteadyMotion& rows = {}) {
  Frame frame;
  frame.intrinsics = camera;
  frame.depth_m = DepthImage(camera.width, camera.height);
  frame.normals = Image<Eigen::Vector3f>(camera.width, camera.height, Eigen::Vector3f::Zero());
  ColourFrame colour{ColourImage(camera.width, camera.height), camera};
  for (int y = 0; y < camera.height; ++y) {
    const Pose T_world_row = T_world_camera * pose_of_row(rows, y, camera.height);
    for (int x = 0; x < camera.width; ++x) {
      const auto met = world.meet(T_world_row.translation(), T_world_row.linear() * camera.unproject(x, y, 1.0));
      if (!met) continue;
      frame.depth_m.at(x, y) = static_cast<float>(met->t);
      frame.normals.at(x, y) = (T_world_row.linear().transpose() * met->normal).cast<float>();
      const auto grey =
          static_cast<std::uint8_t>(std::lround(255 * std::clamp(World::intensity(met->p_world), 0.0, 1.0)));
      colour.image.at(x, y) = {grey, grey, grey};
    }
  }
  if (has_colour) frame.colour = std::move(colour);
  return frame;
}

/// The same as a view of a perfect model.
inline ModelView view_of(const World& world, const Pose& T_world_camera, bool has_colour = true,
                         const CameraIntrinsics& camera = small_camera()) {
  Frame frame = look(world, T_world_camera, has_colour, camera);
  ModelView view{camera, T_world_camera, std::move(frame.depth_m), std::move(frame.normals),
                 Image<float>(camera.width, camera.height, -1.0f)};
  if (!has_colour) return view;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      view.intensity.at(x, y) = static_cast<float>(frame.colour->image.at(x, y).r) / 255.0f;
    }
  }
  return view;
}

/// A step of a circle round the room's middle, 1 m from it; 120 steps close it: 3 degrees and 5 cm each.
inline Pose on_circle(int step) {
  const double angle = step * 2 * kPi / 120;
  const Eigen::Vector3d eye(std::sin(angle), -0.35, -std::cos(angle));
  const Eigen::Vector3d forward = -eye.normalized();
  const Eigen::Vector3d down(0, 1, 0);
  const Eigen::Vector3d right = down.cross(forward).normalized();
  Pose pose = Pose::Identity();
  pose.linear() << right, forward.cross(right), forward;
  pose.translation() = eye;
  return pose;
}

inline Pose motion(const Eigen::Vector3d& turn_rad, const Eigen::Vector3d& shift_m) {
  Pose pose = Pose::Identity();
  if (turn_rad.norm() > 0) pose.linear() = Eigen::AngleAxisd(turn_rad.norm(), turn_rad.normalized()).toRotationMatrix();
  pose.translation() = shift_m;
  return pose;
}

inline double distance_m(const Pose& a, const Pose& b) {
  return (a.translation() - b.translation()).norm();
}

inline double angle_rad(const Pose& a, const Pose& b) {
  return Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle();
}

}  // namespace scanknit::test
