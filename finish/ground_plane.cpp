#include "finish/mesh_steps.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <vector>

#include "core/mesh/mesh_area.h"
#include "finish/finish_pcl.h"
#include "finish/mesh_edges.h"

namespace scanknit {
namespace {

constexpr std::size_t kMostPoints = 60'000;  // that candidates are tried on
constexpr double kAgreement = 0.8;           // cosine between a triangle and the plane that it lies on, 37 degrees

struct Facet {
  Eigen::Vector3d middle, normal;  ///< unit
  double area_m2;
};

std::vector<Facet> facets_of(const Mesh& mesh) {
  std::vector<Facet> facets;
  facets.reserve(mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) {
    const auto at = [&](std::size_t i) { return mesh.positions_m[t[i]].cast<double>().eval(); };
    const Eigen::Vector3d along = area_vector_m2(mesh, t);
    const double area_m2 = along.norm();
    if (!(area_m2 > 0)) continue;
    facets.push_back({(at(0) + at(1) + at(2)) / 3, along / area_m2, area_m2});
  }
  return facets;
}

/// Facets that face up as the ground may, thinned out evenly; a triangle of an extracted mesh is about a voxel large.
std::vector<Eigen::Vector3f> candidates(const std::vector<Facet>& facets, const GroundSearch& search) {
  std::vector<Eigen::Vector3d> points;
  for (const Facet& facet : facets) {
    if (facet.normal.dot(search.expected_up) > std::cos(search.max_tilt_rad)) points.push_back(facet.middle);
  }
  const std::size_t every = points.size() / kMostPoints + 1;
  std::vector<Eigen::Vector3f> thinned;
  for (std::size_t i = 0; i < points.size(); i += every) thinned.push_back(points[i].cast<float>());
  return thinned;
}

/// Of the facets that lie on the plane: its least-squares plane, and how much they are.
struct Fit {
  double area_m2 = 0;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  double rms_m = 0;
};

Fit fit_to(const std::vector<Facet>& facets, const Eigen::Vector3d& up, const Eigen::Vector3d& point,
           double tolerance_m) {
  Fit fit;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  const auto is_on = [&](const Facet& facet) {
    return std::abs(up.dot(facet.middle - point)) <= tolerance_m && facet.normal.dot(up) >= kAgreement;
  };
  for (const Facet& facet : facets) {
    if (!is_on(facet)) continue;
    fit.area_m2 += facet.area_m2;
    sum += facet.area_m2 * facet.middle;
  }
  if (!(fit.area_m2 > 0)) return fit;
  fit.middle = sum / fit.area_m2;
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Facet& facet : facets) {
    if (!is_on(facet)) continue;
    const Eigen::Vector3d away = facet.middle - fit.middle;
    spread += facet.area_m2 / fit.area_m2 * away * away.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
  fit.normal = axes.eigenvectors().col(0);
  if (fit.normal.dot(up) < 0) fit.normal = -fit.normal;
  fit.rms_m = std::sqrt(std::max(0.0, axes.eigenvalues()[0]));
  return fit;
}

/// Spans of points along directions all round in the plane.
class Footprint {
 public:
  explicit Footprint(const Eigen::Vector3d& up) : u_(up.unitOrthogonal()), v_(up.cross(u_)) {}

  void add(const Eigen::Vector3d& p) {
    for (std::size_t i = 0; i < kDirections; ++i) {
      low_[i] = std::min(low_[i], along(i, p));
      high_[i] = std::max(high_[i], along(i, p));
    }
  }
  /// With each span longer by `share` of it at both ends.
  [[nodiscard]] bool contains(const Eigen::Vector3d& p, double share) const {
    for (std::size_t i = 0; i < kDirections; ++i) {
      const double more = share * (high_[i] - low_[i]);
      if (along(i, p) < low_[i] - more || along(i, p) > high_[i] + more) return false;
    }
    return true;
  }

 private:
  static constexpr std::size_t kDirections = 8;
  [[nodiscard]] double along(std::size_t i, const Eigen::Vector3d& p) const {
    const double angle = std::numbers::pi * static_cast<double>(i) / kDirections;
    return std::cos(angle) * u_.dot(p) + std::sin(angle) * v_.dot(p);
  }
  static constexpr double kNothing = std::numeric_limits<double>::infinity();
  Eigen::Vector3d u_, v_;
  std::array<double, kDirections> low_ = filled(kNothing), high_ = filled(-kNothing);
  static constexpr std::array<double, kDirections> filled(double value) {
    std::array<double, kDirections> all{};
    all.fill(value);
    return all;
  }
};

/// False for the plinth or the shoulder of a thing: what stands well within the ground must not reach beyond it.
bool reaches_beyond_what_stands_on_it(const Mesh& mesh, const GroundPlane& ground, double tolerance_m) {
  constexpr double kWithin = -0.1;    // walls and what leans against the rim do not stand on it
  constexpr double kOver = 0.1;       // a thing may hang over by so much
  constexpr double kMostOver = 0.02;  // of the area of what stands on it, farther over than that
  Footprint footprint(ground.up);
  DisjointSets pieces(mesh.positions_m.size());
  const auto height = [&](std::uint32_t v) { return ground.height_m(mesh.positions_m[v].cast<double>()); };
  const auto is_above = [&](const Triangle& t) {
    return std::min({height(t[0]), height(t[1]), height(t[2])}) > tolerance_m;
  };
  const auto middle = [&](const Triangle& t) -> Eigen::Vector3d {
    return (mesh.positions_m[t[0]] + mesh.positions_m[t[1]] + mesh.positions_m[t[2]]).cast<double>() / 3;
  };
  for (const Triangle& t : mesh.triangles) {
    const double level = area_vector_m2(mesh, t).normalized().dot(ground.up);
    if (std::abs(ground.height_m(middle(t))) <= tolerance_m && level >= kAgreement) footprint.add(middle(t));
    if (!is_above(t)) continue;
    pieces.join(t[0], t[1]);
    pieces.join(t[0], t[2]);
  }
  std::vector<std::uint8_t> stands(mesh.positions_m.size());
  for (const Triangle& t : mesh.triangles) {
    const bool is_foot = is_above(t) && ground.height_m(middle(t)) < 4 * tolerance_m;
    if (is_foot && footprint.contains(middle(t), kWithin)) stands[pieces.root(t[0])] = 1;
  }
  double whole_m2 = 0;
  double over_m2 = 0;
  for (const Triangle& t : mesh.triangles) {
    if (!is_above(t) || stands[pieces.root(t[0])] == 0) continue;
    const double area_m2 = area_vector_m2(mesh, t).norm();
    whole_m2 += area_m2;
    if (!footprint.contains(middle(t), kOver)) over_m2 += area_m2;
  }
  return over_m2 <= kMostOver * whole_m2;
}

/// Where the plane (a, b, c, d) leads: fitted to what lies on it, if that can be a ground.
std::optional<GroundPlane> fitted_ground(const Mesh& mesh, const std::vector<Facet>& facets,
                                         const Eigen::Vector4d& plane, const GroundSearch& search) {
  Eigen::Vector3d up = plane.head<3>();
  const double length = up.norm();
  if (!(length > 0)) return std::nullopt;
  Eigen::Vector3d point = -plane[3] / (length * length) * up;
  up /= up.dot(search.expected_up) < 0 ? -length : length;
  Fit fit = fit_to(facets, up, point, search.tolerance_m);
  for (int again = 0; again < 3 && fit.area_m2 > 0; ++again) {
    up = fit.normal;
    point = fit.middle;
    fit = fit_to(facets, up, point, search.tolerance_m);
  }
  double whole_m2 = 0;
  for (const Facet& facet : facets) whole_m2 += facet.area_m2;
  const double tilt = std::acos(std::clamp(up.dot(search.expected_up), -1.0, 1.0));
  if (!(fit.area_m2 >= search.min_share * whole_m2) || tilt > search.max_tilt_rad) return std::nullopt;
  const GroundPlane ground{up, point, fit.area_m2, fit.area_m2 / whole_m2, fit.rms_m, tilt};
  if (!reaches_beyond_what_stands_on_it(mesh, ground, search.tolerance_m)) return std::nullopt;
  return ground;
}

}  // namespace

Result<std::optional<GroundPlane>> find_ground(const Mesh& mesh, const GroundSearch& search) {
  const std::vector<Facet> facets = facets_of(mesh);
  const std::vector<Eigen::Vector3f> points = candidates(facets, search);
  if (points.size() < 3) return std::optional<GroundPlane>();
  const auto pcl = load_finish_pcl();
  if (!pcl) return pcl.error();
  const auto plane = (*pcl)->find_plane(points, search);
  return plane ? fitted_ground(mesh, facets, *plane, search) : std::nullopt;
}

}  // namespace scanknit
