#include "acquire/synthetic/camera_paths.h"

#include <cmath>
#include <numbers>

namespace scanknit {
namespace {

constexpr double kFullTurn = 2 * std::numbers::pi;
constexpr double kDegree = std::numbers::pi / 180;

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
    const double gaze = azimuth + 60 * kDegree;  // the way of walking is at 90 degrees
    const Eigen::Vector3d eye(path.half_length_m * std::sin(azimuth), -path.half_width_m * std::cos(azimuth),
                              path.height_m);
    // Three nods a loop: the floor and the upper half of the walls both come into view.
    const double slope = -0.25 + 0.2 * std::sin(3 * azimuth);
    return look_at(eye, eye + Eigen::Vector3d(std::sin(gaze), -std::cos(gaze), slope));
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
