#include "synth/scene/camera_paths.h"
#include "core/rotation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace scanknit {
namespace {

/// A position on the path, and the direction of walking.
struct Waypoint {
  Eigen::Vector2d place;
  double heading_rad;
};

/// The waypoint after `walked_m`, counter-clockwise round the rectangle from the middle of its near side.
Waypoint on_ring(const RingPath& path, double walked_m) {
  const double r = path.corner_radius_m;
  const double straight[2] = {2 * (path.half_length_m - r), 2 * (path.half_width_m - r)};
  const double quarter = r * kFullTurn / 4;
  Waypoint at{{0, -path.half_width_m}, 0};
  const auto ahead = [&](double metres) {
    at.place += metres * Eigen::Vector2d(std::cos(at.heading_rad), std::sin(at.heading_rad));
  };
  double left = std::fmod(walked_m, 2 * (straight[0] + straight[1]) + 4 * quarter);
  for (int side = 0; side < 5; ++side) {
    const double whole = straight[side % 2] * (side == 0 || side == 4 ? 0.5 : 1.0);
    ahead(std::min(left, whole));
    if (left <= whole) break;
    left -= whole;
    const double turn = std::min(left, quarter) / r;
    const Eigen::Vector2d centre = at.place + r * Eigen::Vector2d(-std::sin(at.heading_rad), std::cos(at.heading_rad));
    at.heading_rad += turn;
    at.place = centre + r * Eigen::Vector2d(std::sin(at.heading_rad), -std::cos(at.heading_rad));
    if (left <= quarter) break;
    left -= quarter;
  }
  return at;
}

}  // namespace

Pose T_world_plan() {
  Pose pose = Pose::Identity();
  pose.linear().col(0) = Eigen::Vector3d(1, 0, 0);
  pose.linear().col(1) = Eigen::Vector3d(0, 0, 1);
  pose.linear().col(2) = Eigen::Vector3d(0, -1, 0);
  return pose;
}

Pose look_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target) {
  const Eigen::Vector3d forward = (target - eye).normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  Pose T_plan_camera = Pose::Identity();
  T_plan_camera.linear() << right, forward.cross(right), forward;
  T_plan_camera.translation() = eye;
  return T_world_plan() * T_plan_camera;
}

CameraPath turntable_path(const TurntablePath& path) {
  return [path](double s) {
    const double elevation = 55 * kDegree * std::cos(std::numbers::pi * s);
    const double azimuth = kFullTurn * path.turns * s;
    const Eigen::Vector3d direction(std::sin(azimuth) * std::cos(elevation), -std::cos(azimuth) * std::cos(elevation),
                                    std::sin(elevation));
    return look_at(path.centre + path.distance_m * direction, path.centre);
  };
}

CameraPath orbit_path(const OrbitPath& path) {
  return [path](double s) {
    const double azimuth = kFullTurn * path.turns * s;
    const double radius = path.first_radius_m + s * (path.last_radius_m - path.first_radius_m);
    const Eigen::Vector3d eye(path.target.x() + radius * std::sin(azimuth),
                              path.target.y() - radius * std::cos(azimuth), path.height_m);
    return look_at(eye, path.target);
  };
}

CameraPath walk_path(const WalkPath& path) {
  return [path](double s) {
    const double azimuth = kFullTurn * s;
    const double gaze = azimuth + 60 * kDegree;  // the walking direction is at 90 degrees
    const Eigen::Vector3d eye(path.half_length_m * std::sin(azimuth), -path.half_width_m * std::cos(azimuth),
                              path.height_m);
    // Three nods in a loop, so that both the floor and the upper half of the walls come into view.
    const double slope = -0.25 + 0.2 * std::sin(3 * azimuth);
    return look_at(eye, eye + Eigen::Vector3d(std::sin(gaze), -std::cos(gaze), slope));
  };
}

CameraPath ring_path(const RingPath& path) {
  return [path](double s) {
    const double r = path.corner_radius_m;
    const double round_m = 4 * (path.half_length_m + path.half_width_m - 2 * r) + kFullTurn * r;
    const Waypoint at = on_ring(path, path.rounds * round_m * s);
    const double gaze = at.heading_rad - 20 * kDegree;
    const double slope = -0.2 + 0.1 * std::sin(9 * kFullTurn * s);
    const Eigen::Vector3d eye(at.place.x(), at.place.y(), path.height_m);
    return look_at(eye, eye + Eigen::Vector3d(std::cos(gaze), std::sin(gaze), slope));
  };
}

CameraPath crossing_path(const CrossingPath& path) {
  return [path](double s) {
    const double gaze = path.first_gaze_rad - s * kFullTurn / 2;
    const Eigen::Vector3d eye(path.half_length_m * (2 * s - 1), 0, path.height_m);
    return look_at(eye, eye + Eigen::Vector3d(std::cos(gaze), std::sin(gaze), -0.2));
  };
}

CameraPath straight_path(const StraightPath& path) {
  return [path](double s) {
    const double gaze = path.gaze_rad + path.swing_rad * std::sin(3 * kFullTurn * s);
    const Eigen::Vector3d eye = path.from + s * (path.to - path.from);
    return look_at(eye, eye + Eigen::Vector3d(std::cos(gaze), std::sin(gaze), path.slope));
  };
}

std::vector<Pose> camera_path(const SyntheticScene& scene, int frames) {
  const int count = frames > 0 ? frames : scene.default_frames();
  std::vector<Pose> poses;
  poses.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) poses.push_back(scene.path()(static_cast<double>(i) / count));
  return poses;
}

}  // namespace scanknit
