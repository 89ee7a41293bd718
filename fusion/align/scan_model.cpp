#include "fusion/align/scan_model.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "core/median.h"

namespace scanknit {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

/// A scan becomes some thousand points at the coarse scale, some ten thousand at the fine one.
constexpr double kCoarseCells = 40;
constexpr double kFineCells = 200;

/// Of the box round the points, without the outermost hundredth at each end.
double diagonal(const OrientedPoints& points) {
  Vector3d size;
  std::vector<float> values(points.size());
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < points.size(); ++i) values[i] = points.points_m[i][axis];
    const auto cut = static_cast<std::ptrdiff_t>(values.size() / 100);
    std::nth_element(values.begin(), values.begin() + cut, values.end());
    const float low = values[static_cast<std::size_t>(cut)];
    std::nth_element(values.begin(), values.end() - 1 - cut, values.end());
    size[axis] = double{*(values.end() - 1 - cut)} - low;
  }
  return size.norm();
}

std::vector<Vector3f> triangle_normals(const Mesh& mesh) {
  std::vector<Vector3f> normals(mesh.positions_m.size(), Vector3f::Zero());
  for (const Triangle& t : mesh.triangles) {
    const Vector3f across = (mesh.positions_m[t[1]] - mesh.positions_m[t[0]])
                                .cross(Vector3f(mesh.positions_m[t[2]] - mesh.positions_m[t[0]]));
    for (const std::uint32_t corner : t) normals[corner] += across;
  }
  for (Vector3f& normal : normals) normal = normal.stableNormalized();
  return normals;
}

/// Vertices of edges that have one triangle.
std::vector<std::uint8_t> rim_of(const Mesh& mesh) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) edges.push_back(std::minmax(t[k], t[(k + 1) % 3]));
  }
  std::sort(edges.begin(), edges.end());
  std::vector<std::uint8_t> is_rim(mesh.positions_m.size(), 0);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const bool is_shared = (i > 0 && edges[i - 1] == edges[i]) || (i + 1 < edges.size() && edges[i + 1] == edges[i]);
    if (!is_shared) is_rim[edges[i].first] = is_rim[edges[i].second] = 1;
  }
  return is_rim;
}

double median_edge(const Mesh& mesh) {
  std::vector<float> lengths;
  const std::size_t every = std::max<std::size_t>(1, mesh.triangles.size() / 20'000);
  for (std::size_t i = 0; i < mesh.triangles.size(); i += every) {
    const Triangle& t = mesh.triangles[i];
    lengths.push_back((mesh.positions_m[t[1]] - mesh.positions_m[t[0]]).norm());
  }
  return double{median(std::move(lengths))};
}

}  // namespace

ScanModel model_of(const RangeScan& scan, const RangeSurface& surface) {
  ScanModel model{.name = scan.name, .all = {}, .spacing_m = surface.spacing_m, .sights = {}};
  for (std::size_t i = 0; i < scan.points_m.size(); ++i) {
    if (surface.inset.pixels()[i] == 0) continue;
    model.all.points_m.push_back(scan.points_m.pixels()[i]);
    model.all.normals.push_back(surface.normals.pixels()[i]);
    model.all.is_rim.push_back(surface.inset.pixels()[i] <= 2 ? 1 : 0);
  }
  model.sights.push_back({RangeView(scan, surface), Pose::Identity()});
  return model;
}

ScanModel model_of(const Mesh& mesh, std::string name) {
  ScanModel model{.name = std::move(name), .all = {}, .spacing_m = median_edge(mesh), .sights = {}};
  const std::vector<Vector3f> normals = mesh.normals.empty() ? triangle_normals(mesh) : mesh.normals;
  const std::vector<std::uint8_t> is_rim = rim_of(mesh);
  for (std::size_t i = 0; i < mesh.positions_m.size(); ++i) {
    if (!(normals[i].norm() > 0.5f)) continue;
    model.all.points_m.push_back(mesh.positions_m[i]);
    model.all.normals.push_back(normals[i].normalized());
    model.all.is_rim.push_back(is_rim[i]);
  }
  return model;
}

AlignScale choose_scale(const std::vector<ScanModel>& models) {
  double smallest = HUGE_VAL;
  double spacing = 0;
  for (const ScanModel& model : models) {
    if (model.all.size() < 2) continue;
    smallest = std::min(smallest, diagonal(model.all));
    spacing = std::max(spacing, model.spacing_m);
  }
  if (!(smallest > 0) || smallest == HUGE_VAL) return {};
  const double fine = std::max(smallest / kFineCells, spacing);
  return {std::max(smallest / kCoarseCells, 2 * fine), fine};
}

OrientedPoints thin_out(const OrientedPoints& points, double cell_m) {
  using Key = std::array<std::int64_t, 4>;
  std::vector<std::pair<Key, std::uint32_t>> order(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    Key key{};
    for (int axis = 0; axis < 3; ++axis) {
      key[static_cast<std::size_t>(axis)] =
          static_cast<std::int64_t>(std::floor(double{points.points_m[i][axis]} / cell_m));
    }
    Eigen::Index side = 0;
    points.normals[i].cwiseAbs().maxCoeff(&side);
    key[3] = points.normals[i][side] < 0 ? side : side + 3;
    order[i] = {key, static_cast<std::uint32_t>(i)};
  }
  std::sort(order.begin(), order.end());
  OrientedPoints thin;
  for (std::size_t i = 0; i < order.size();) {
    Vector3d point = Vector3d::Zero();
    Vector3d normal = Vector3d::Zero();
    std::size_t end = i;
    bool is_rim = false;
    for (; end < order.size() && order[end].first == order[i].first; ++end) {
      const std::uint32_t at = order[end].second;
      point += points.points_m[at].cast<double>();
      normal += points.normals[at].cast<double>();
      is_rim = is_rim || points.is_rim[at] != 0;
    }
    thin.points_m.push_back((point / static_cast<double>(end - i)).cast<float>());
    thin.normals.push_back(normal.normalized().cast<float>());
    thin.is_rim.push_back(is_rim ? 1 : 0);
    i = end;
  }
  return thin;
}

}  // namespace scanknit
