#include "synth/scene/drawing.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "core/rotation.h"

namespace scanknit {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

Pose placed(const Vector3d& centre, const Eigen::Matrix3d& turn) {
  Pose pose = Pose::Identity();
  pose.linear() = turn;
  pose.translation() = centre;
  return pose;
}

}  // namespace

Texture paint(int index, Pattern pattern, double period_m) {
  const double hue = 2.399963 * index;  // the golden angle: successive hues differ strongly
  Texture texture{.pattern = pattern, .period_m = period_m};
  for (int c = 0; c < 3; ++c) {
    const double wave = std::cos(hue + 2 * std::numbers::pi * c / 3);
    texture.light[c] = 0.70 + 0.25 * wave;
    texture.dark[c] = 0.28 + 0.15 * wave;
  }
  return texture;
}

Texture bare(int index) {
  Texture texture = paint(index, Pattern::kMarble, 0.7);
  texture.dark = texture.light - Eigen::Vector3d::Constant(0.03);
  return texture;
}

Lathe frustum(double bottom_radius, double top_radius, double height) {
  const double h = height / 2;
  return {{Vector2d(0, -h), Vector2d(bottom_radius, -h), Vector2d(top_radius, h), Vector2d(0, h)}};
}

Lathe vase() {
  return {{Vector2d(0, -0.11), Vector2d(0.04, -0.11), Vector2d(0.06, -0.03), Vector2d(0.03, 0.06),
           Vector2d(0.045, 0.11), Vector2d(0, 0.11)}};
}

void Drawing::add(Shape shape, const Vector3d& centre, const Texture& texture, const Eigen::Matrix3d& turn,
                  const SurfaceMaterial& material) {
  solids_.emplace_back(std::move(shape), T_world_plan() * placed(centre, turn), texture);
  made_of(material);
}

void Drawing::stand_box(double x, double y, double floor_m, const Vector3d& size, const Texture& texture,
                        double turn_degrees, double rounding_m) {
  const Vector3d full = size + Vector3d(0, 0, kSunk_m);
  add(Box{full / 2, rounding_m}, {x, y, floor_m - kSunk_m + full.z() / 2}, texture, yaw(turn_degrees));
}

void Drawing::stand_cylinder(double x, double y, double floor_m, double radius, double height, const Texture& texture) {
  const double full = height + kSunk_m;
  add(Cylinder{radius, full / 2, 0.003}, {x, y, floor_m - kSunk_m + full / 2}, texture);
}

void Drawing::add_rod(const Vector3d& from, const Vector3d& to, double radius_m, const Texture& texture) {
  const Vector3d along = to - from;
  const Eigen::Matrix3d turn = rotation_between(Vector3d::UnitZ(), along.normalized()).toRotationMatrix();
  add(Cylinder{radius_m, along.norm() / 2 + 0.6 * radius_m, 0.6 * radius_m}, (from + to) / 2, texture, turn);
}

void Drawing::add_room(const Vector3d& size, const Texture& texture) {
  solids_.push_back(Solid::room(size / 2, T_world_plan() * placed({0, 0, size.z() / 2}, yaw(0)), texture));
}

std::unique_ptr<SyntheticScene> Drawing::scene(std::string name, CameraPath path, int default_frames) && {
  return std::make_unique<AnalyticScene>(std::move(name), std::move(path), default_frames, std::move(solids_));
}

Eigen::Matrix3d Drawing::yaw(double degrees) {
  return Eigen::AngleAxisd(degrees * kDegree, Vector3d::UnitZ()).toRotationMatrix();
}

Eigen::Matrix3d Drawing::roll(double degrees) {
  return Eigen::AngleAxisd(degrees * kDegree, Vector3d::UnitX()).toRotationMatrix();
}

}  // namespace scanknit
