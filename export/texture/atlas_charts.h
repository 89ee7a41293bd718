// Charts: cuts a mesh into patches whose projections onto a plane do not overlap themselves.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/mesh.h"
#include "export/texture/texel_raster.h"

namespace scanknit {

/// The plane of a chart: a right-handed frame whose third axis points out of the surface.
struct ChartPlane {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::Vector3d u = Eigen::Vector3d::UnitX(), v = Eigen::Vector3d::UnitY();
  double texel = 1;  ///< in the mesh's unit

  /// The projection of a point; depends only on the point, so that neighbours agree.
  [[nodiscard]] TexelPoint project(const Eigen::Vector3f& p) const {
    const Eigen::Vector3d from_origin = p.cast<double>() - origin;
    return {steps(from_origin.dot(u)), steps(from_origin.dot(v))};
  }
  [[nodiscard]] std::array<TexelPoint, 3> project(const Mesh& mesh, const Triangle& t) const {
    return {project(mesh.positions_m[t[0]]), project(mesh.positions_m[t[1]]), project(mesh.positions_m[t[2]])};
  }

 private:
  /// Clamped to +-2^29, far beyond any texture.
  [[nodiscard]] std::int32_t steps(double length) const {
    constexpr double kFarthest = 1 << 29;
    const double steps = length / texel * static_cast<double>(kTexelSteps);
    return static_cast<std::int32_t>(std::lround(std::clamp(steps, -kFarthest, kFarthest)));
  }
};

struct Charts {
  std::vector<ChartPlane> planes;       ///< one for each chart
  std::vector<std::uint32_t> chart_of;  ///< one for each triangle
};

/// Grows patches of connected triangles, within 60 degrees of the plane, or 78 if else only a small patch would be
/// left. No texel has its centre in two triangles of one chart: where a patch would overlap itself, another begins. No
/// chart is wider or higher than `max_side` texels; a larger triangle gets a chart of its own. The same for any number
/// of threads. `texel` > 0, in the mesh's unit; `max_side` in 1..2048.
[[nodiscard]] Charts grow_charts(const Mesh& mesh, double texel, int max_side);

}  // namespace scanknit
