#include "synth/render.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace scanknit {
namespace {

std::uint8_t to_byte(double value) {
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(value, 0.0, 1.0)));
}

void render_row(const SyntheticScene& scene, const ViewCamera& camera, int y, RenderedView& view) {
  const Pose& T_world_camera = camera.T_world_camera(y);
  for (int x = 0; x < view.depth_m.width(); ++x) {
    const Eigen::Vector3d through = camera.through(x, y);
    const double length_per_depth = through.norm();
    const Ray ray{T_world_camera.translation(), T_world_camera.linear() * (through / length_per_depth)};
    const auto t = scene.intersect(ray, kRenderRange_m);
    if (!t) continue;
    const SurfacePoint hit = scene.nearest(ray.at(*t));
    const Eigen::Vector3d colour = scene.colour(hit);
    view.depth_m.at(x, y) = static_cast<float>(*t / length_per_depth);
    view.cos_incidence.at(x, y) = static_cast<float>(std::clamp(-hit.normal.dot(ray.direction), 0.0, 1.0));
    view.colour.at(x, y) = {to_byte(colour.x()), to_byte(colour.y()), to_byte(colour.z())};
    view.material.at(x, y) = scene.material(hit);
  }
}

}  // namespace

RenderedView render(const SyntheticScene& scene, const CameraIntrinsics& intrinsics, const Pose& T_world_camera) {
  return render(scene, ViewCamera(intrinsics, T_world_camera));
}

RenderedView render(const SyntheticScene& scene, const ViewCamera& camera) {
  const int width = camera.intrinsics().width;
  const int height = camera.intrinsics().height;
  RenderedView view{DepthImage(width, height), Image<float>(width, height), ColourImage(width, height),
                    Image<SurfaceMaterial>(width, height)};
  tbb::parallel_for(0, height, [&](int y) { render_row(scene, camera, y, view); });
  return view;
}

void put_in_front(const RenderedView& other, RenderedView& view) {
  for (int y = 0; y < view.depth_m.height(); ++y) {
    for (int x = 0; x < view.depth_m.width(); ++x) {
      const float z = other.depth_m.at(x, y);
      if (!(z > 0) || (view.depth_m.at(x, y) > 0 && view.depth_m.at(x, y) <= z)) continue;
      view.depth_m.at(x, y) = z;
      view.cos_incidence.at(x, y) = other.cos_incidence.at(x, y);
      view.colour.at(x, y) = other.colour.at(x, y);
      view.material.at(x, y) = other.material.at(x, y);
    }
  }
}

}  // namespace scanknit
