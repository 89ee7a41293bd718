#include "synth/render.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace scanknit {
namespace {

std::uint8_t to_byte(double value) {
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(value, 0.0, 1.0)));
}

void render_row(const SyntheticScene& scene, const CameraIntrinsics& intrinsics, const Pose& T_world_camera, int y,
                RenderedView& view) {
  for (int x = 0; x < intrinsics.width; ++x) {
    const Eigen::Vector3d through = intrinsics.unproject(x, y, 1.0);
    const double length_per_depth = through.norm();
    const Ray ray{T_world_camera.translation(), T_world_camera.linear() * (through / length_per_depth)};
    const auto t = scene.intersect(ray, kRenderRange_m);
    if (!t) continue;
    const SurfacePoint hit = scene.nearest(ray.at(*t));
    const Eigen::Vector3d colour = scene.colour(hit);
    view.depth_m.at(x, y) = static_cast<float>(*t / length_per_depth);
    view.cos_incidence.at(x, y) = static_cast<float>(std::clamp(-hit.normal.dot(ray.direction), 0.0, 1.0));
    view.colour.at(x, y) = {to_byte(colour.x()), to_byte(colour.y()), to_byte(colour.z())};
  }
}

}  // namespace

RenderedView render(const SyntheticScene& scene, const CameraIntrinsics& intrinsics, const Pose& T_world_camera) {
  RenderedView view{DepthImage(intrinsics.width, intrinsics.height), Image<float>(intrinsics.width, intrinsics.height),
                    ColourImage(intrinsics.width, intrinsics.height)};
  tbb::parallel_for(0, intrinsics.height, [&](int y) { render_row(scene, intrinsics, T_world_camera, y, view); });
  return view;
}

}  // namespace scanknit
