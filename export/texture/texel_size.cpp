#include "export/texture/texel_size.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/median.h"

namespace scanknit {

std::optional<double> fitting_texel_m(const Mesh& mesh, const CameraIntrinsics& camera,
                                      std::span<const Pose> T_world_cameras) {
  constexpr std::size_t kEnough = 2000;  // vertices and poses to look at
  constexpr double kTexelsPerPixel = 0.75;
  const std::size_t step = mesh.positions_m.size() / kEnough + 1;
  const std::size_t pose_step = T_world_cameras.size() / kEnough + 1;
  std::vector<double> nearest_m(mesh.positions_m.size() / step + 1, std::numeric_limits<double>::infinity());
  for (std::size_t k = 0; k < T_world_cameras.size(); k += pose_step) {
    const Pose T_camera_world = T_world_cameras[k].inverse();
    for (std::size_t i = 0; i < mesh.positions_m.size(); i += step) {
      const Eigen::Vector3d p = T_camera_world * mesh.positions_m[i].cast<double>();
      if (!(p.z() > 0)) continue;
      const Eigen::Vector2d pixel = camera.project(p);
      const bool is_inside =
          pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= camera.width - 1 && pixel.y() <= camera.height - 1;
      if (is_inside) nearest_m[i / step] = std::min(nearest_m[i / step], p.z());
    }
  }
  std::erase_if(nearest_m, [](double z_m) { return std::isinf(z_m); });
  if (nearest_m.empty()) return std::nullopt;
  return kTexelsPerPixel * median(std::move(nearest_m)) / std::sqrt(std::abs(camera.fx * camera.fy));
}

}  // namespace scanknit
