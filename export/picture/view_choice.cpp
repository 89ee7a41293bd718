#include "export/picture/view_choice.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/median.h"
#include "core/mesh/mesh_area.h"
#include "core/rotation.h"
#include "export/mesh/up_rotation.h"

namespace scanknit {
namespace {

constexpr int kAzimuths = 16;
constexpr double kElevation = 25 * kDegree;
constexpr double kElevationFromAbove = 60 * kDegree;
// Of the front view's surface, what a second view must show to be worth a picture.
constexpr double kWorthShowing = 0.6;
// A later candidate must be better by more than rounding, so that a sphere has the same front on every machine.
constexpr double kClearlyBetter = 1.001;
constexpr std::size_t kEnoughTriangles = 200'000;

Eigen::Vector3d forward_at(const Eigen::Vector3d& up, double azimuth, double elevation) {
  const Eigen::Vector3d right = up.unitOrthogonal();
  const Eigen::Vector3d ahead = up.cross(right);
  const Eigen::Vector3d level = std::cos(azimuth) * ahead + std::sin(azimuth) * right;
  return std::cos(elevation) * level - std::sin(elevation) * up;
}

/// The area that faces a viewer who looks along each azimuth, whatever hides it.
std::array<double, kAzimuths> facing_areas(const Mesh& mesh, const Eigen::Vector3d& up) {
  std::array<Eigen::Vector3d, kAzimuths> forward;
  for (int i = 0; i < kAzimuths; ++i) {
    forward[static_cast<std::size_t>(i)] = forward_at(up, i * 2 * std::numbers::pi / kAzimuths, kElevation);
  }
  std::array<double, kAzimuths> areas{};
  const std::size_t step = mesh.triangles.size() / kEnoughTriangles + 1;
  for (std::size_t i = 0; i < mesh.triangles.size(); i += step) {
    const Eigen::Vector3d area = area_vector_m2(mesh, mesh.triangles[i]);
    for (std::size_t k = 0; k < forward.size(); ++k) areas[k] += std::max(0.0, -area.dot(forward[k]));
  }
  return areas;
}

}  // namespace

std::array<View, 4> choose_views(const Mesh& mesh, UpAxis world_up) {
  const Eigen::Vector3d up = direction(world_up).cast<double>();
  const auto areas = facing_areas(mesh, up);
  int front = 0;
  for (int i = 1; i < kAzimuths; ++i) {
    if (areas[static_cast<std::size_t>(i)] > kClearlyBetter * areas[static_cast<std::size_t>(front)]) front = i;
  }
  // As far round as there is something to see: 135 degrees to either side, then 90, then 45.
  int second = (front + 2) % kAzimuths;
  for (const int offset : {6, -6, 4, -4, 2, -2}) {
    const int candidate = (front + offset + kAzimuths) % kAzimuths;
    if (areas[static_cast<std::size_t>(candidate)] >= kWorthShowing * areas[static_cast<std::size_t>(front)]) {
      second = candidate;
      break;
    }
  }
  const auto view = [&](int azimuth, double elevation, bool in_colour) {
    return View{forward_at(up, azimuth * 2 * std::numbers::pi / kAzimuths, elevation), up, in_colour};
  };
  return {view(front, kElevation, true), view(second, kElevation, true), view(front, kElevationFromAbove, true),
          view(front, kElevation, false)};
}

View scanner_view(const Pose& T_world_scanner, UpAxis world_up) {
  View view;
  view.forward = T_world_scanner.linear().col(2);
  view.up = -T_world_scanner.linear().col(1);
  if (view.up.dot(direction(world_up).cast<double>()) < 0) view.up = -view.up;
  return view;
}

Framing framing_seen_from(const Mesh& mesh, const Pose& T_world_scanner) {
  constexpr double kTangent = 0.577;  // of 30 degrees, half the field of view of a common depth camera
  constexpr float kForeground = 1.5f;
  constexpr std::size_t kEnough = 100;
  const Pose T_scanner_world = T_world_scanner.inverse();
  Mesh seen;
  std::vector<float> depths_m;
  for (const Eigen::Vector3f& p_world : mesh.positions_m) {
    const Eigen::Vector3d p = T_scanner_world * p_world.cast<double>();
    if (p.z() <= 0 || p.head<2>().norm() > kTangent * p.z()) continue;
    seen.positions_m.push_back(p_world);
    depths_m.push_back(static_cast<float>(p.z()));
  }
  if (depths_m.size() < kEnough) return framing(mesh);
  const float middle_m = median(depths_m);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < depths_m.size(); ++i) {
    if (depths_m[i] <= kForeground * middle_m) seen.positions_m[kept++] = seen.positions_m[i];
  }
  seen.positions_m.resize(kept);
  return framing(seen);
}

}  // namespace scanknit
