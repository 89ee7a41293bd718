#include "export/texture/atlas_charts.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/check.h"
#include "core/mesh/mesh_area.h"

namespace scanknit {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
constexpr double kFacing = 0.5;        // cosine of 60 degrees: no texel stands for more than twice its area
constexpr double kLeaning = 0.2;       // of 78 degrees: for what would else become crumbs
constexpr std::size_t kCrumb = 64;     // a chart of fewer triangles is left to its neighbours
constexpr std::size_t kPlaneOf = 256;  // triangles around the first that say which way the plane looks

using Neighbours = std::array<std::uint32_t, 3>;  ///< across edges 01, 12, 20; kNone at a rim

struct HalfEdge {
  std::uint64_t ends;
  std::uint32_t triangle, side;
  friend bool operator<(const HalfEdge& a, const HalfEdge& b) {
    if (a.ends != b.ends) return a.ends < b.ends;
    return a.triangle != b.triangle ? a.triangle < b.triangle : a.side < b.side;
  }
};

/// Where more than two triangles meet at an edge, none is another's neighbour.
std::vector<Neighbours> find_neighbours(const Mesh& mesh) {
  std::vector<HalfEdge> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::uint32_t side = 0; side < 3; ++side) {
      const auto [low, high] = std::minmax({mesh.triangles[t][side], mesh.triangles[t][(side + 1) % 3]});
      edges.push_back({std::uint64_t{low} << 32 | high, t, side});
    }
  }
  tbb::parallel_sort(edges.begin(), edges.end());
  std::vector<Neighbours> neighbours(mesh.triangles.size(), {kNone, kNone, kNone});
  for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
    while (end < edges.size() && edges[end].ends == edges[begin].ends) ++end;
    if (end - begin != 2) continue;
    const HalfEdge& a = edges[begin];
    const HalfEdge& b = edges[begin + 1];
    neighbours[a.triangle][a.side] = b.triangle;
    neighbours[b.triangle][b.side] = a.triangle;
  }
  return neighbours;
}

/// Of each triangle, times its area.
std::vector<Eigen::Vector3f> area_normals(const Mesh& mesh) {
  std::vector<Eigen::Vector3f> normals;
  normals.reserve(mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) normals.push_back(area_vector_m2(mesh, t).cast<float>());
  return normals;
}

/// The texels that one chart covers so far. Forgets the chart before at no cost.
class CoveredTexels {
 public:
  explicit CoveredTexels(int max_side) : side_(2 * max_side + 4), stamps_(square(side_), 0) {}

  void begin_chart() { ++chart_; }
  /// Texels count from the chart's origin, and lie within +-max_side of it.
  [[nodiscard]] bool is_covered(int x, int y) const { return stamps_[index(x, y)] == chart_; }
  void cover(int x, int y) { stamps_[index(x, y)] = chart_; }

 private:
  [[nodiscard]] static std::size_t square(int side) {
    return static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
  }
  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y + side_ / 2) * static_cast<std::size_t>(side_) +
           static_cast<std::size_t>(x + side_ / 2);
  }
  int side_;
  std::vector<std::uint32_t> stamps_;
  std::uint32_t chart_ = 0;
};

class ChartGrower {
 public:
  ChartGrower(const Mesh& mesh, double texel, int max_side)
      : mesh_(mesh),
        texel_(texel),
        max_side_(max_side),
        neighbours_(find_neighbours(mesh)),
        normals_(area_normals(mesh)),
        chart_of_(mesh.triangles.size(), kNone),
        was_looked_at_(mesh.triangles.size(), 0),
        covered_(max_side) {}

  [[nodiscard]] Charts grow() {
    grow_all(kFacing);
    free_crumbs();
    for (std::uint32_t chart = 0; chart < planes_.size(); ++chart) widen(chart);
    grow_all(kLeaning);
    renumber();
    return {std::move(planes_), std::move(chart_of_)};
  }

 private:
  struct Extent {
    std::int64_t x0 = 0, x1 = 0, y0 = 0, y1 = 0;  ///< steps; holds the origin
    [[nodiscard]] Extent with(const std::array<TexelPoint, 3>& p) const {
      Extent e = *this;
      for (const TexelPoint& q : p) {
        e.x0 = std::min<std::int64_t>(e.x0, q.x);
        e.x1 = std::max<std::int64_t>(e.x1, q.x);
        e.y0 = std::min<std::int64_t>(e.y0, q.y);
        e.y1 = std::max<std::int64_t>(e.y1, q.y);
      }
      return e;
    }
  };

  void grow_all(double cosine) {
    for (std::uint32_t t = 0; t < chart_of_.size(); ++t) {
      if (chart_of_[t] == kNone) begin_at(t, cosine);
    }
  }

  void begin_at(std::uint32_t seed, double cosine) {
    const auto chart = static_cast<std::uint32_t>(planes_.size());
    planes_.push_back(plane_at(seed, cosine));
    covered_.begin_chart();
    extent_ = {};
    if (try_add(seed, chart)) {
      spread({seed}, chart, cosine);
    } else {
      chart_of_[seed] = chart;  // larger than a chart may be: it is alone
    }
  }

  /// What may lean more joins a chart that is there.
  void widen(std::uint32_t chart) {
    if (members_[chart].empty()) return;
    covered_.begin_chart();
    extent_ = {};
    for (const std::uint32_t t : members_[chart]) {
      const auto p = planes_[chart].project(mesh_, mesh_.triangles[t]);
      extent_ = extent_.with(p);
      for_each_texel(p, [&](int x, int y, const auto&) { return covered_.cover(x, y), true; });
    }
    spread(members_[chart], chart, kLeaning);
  }

  /// Breadth first over free triangles that look along the chart's plane.
  void spread(std::vector<std::uint32_t> queue, std::uint32_t chart, double cosine) {
    ++look_;
    for (std::size_t next = 0; next < queue.size(); ++next) {
      for (const std::uint32_t t : neighbours_[queue[next]]) {
        if (t == kNone || chart_of_[t] != kNone || was_looked_at_[t] == look_) continue;
        was_looked_at_[t] = look_;
        if (looks_along(t, out_of(planes_[chart]), cosine) && try_add(t, chart)) queue.push_back(t);
      }
    }
  }

  /// Slivers without area look along everything.
  [[nodiscard]] bool looks_along(std::uint32_t t, const Eigen::Vector3d& out, double cosine) const {
    const Eigen::Vector3d n = normals_[t].cast<double>();
    return n.dot(out) >= cosine * n.norm();
  }

  [[nodiscard]] static Eigen::Vector3d out_of(const ChartPlane& plane) { return plane.u.cross(plane.v); }

  [[nodiscard]] bool fits(const std::array<TexelPoint, 3>& p) const {
    const Extent e = extent_.with(p);
    const std::int64_t most = max_side_ * kTexelSteps;
    return e.x1 - e.x0 <= most && e.y1 - e.y0 <= most;
  }

  /// False: it would cover what the chart covers already, or make it too large.
  [[nodiscard]] bool try_add(std::uint32_t t, std::uint32_t chart) {
    const auto p = planes_[chart].project(mesh_, mesh_.triangles[t]);
    if (!fits(p)) return false;
    if (!for_each_texel(p, [&](int x, int y, const auto&) { return !covered_.is_covered(x, y); })) return false;
    for_each_texel(p, [&](int x, int y, const auto&) { return covered_.cover(x, y), true; });
    extent_ = extent_.with(p);
    chart_of_[t] = chart;
    return true;
  }

  /// Looks as the surface does around `seed`, but never away from it.
  [[nodiscard]] ChartPlane plane_at(std::uint32_t seed, double cosine) {
    ChartPlane plane;
    plane.texel = texel_;
    plane.origin = mesh_.positions_m[mesh_.triangles[seed][0]].cast<double>();
    Eigen::Vector3d out = normals_[seed].cast<double>();
    out = out.norm() > 0 ? out.normalized().eval() : Eigen::Vector3d(Eigen::Vector3d::UnitZ());
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    ++look_;
    was_looked_at_[seed] = look_;
    std::vector<std::uint32_t> queue = {seed};
    for (std::size_t next = 0; next < queue.size(); ++next) {
      sum += normals_[queue[next]].cast<double>();
      for (const std::uint32_t t : neighbours_[queue[next]]) {
        if (t == kNone || chart_of_[t] != kNone || was_looked_at_[t] == look_ || queue.size() >= kPlaneOf) continue;
        was_looked_at_[t] = look_;
        if (looks_along(t, out, cosine)) queue.push_back(t);
      }
    }
    if (sum.norm() > 0 && looks_along(seed, sum.normalized(), cosine)) out = sum.normalized();
    Eigen::Index least = 0;
    out.cwiseAbs().minCoeff(&least);
    plane.u = Eigen::Vector3d::Unit(least).cross(out).normalized();
    plane.v = out.cross(plane.u);
    return plane;
  }

  void free_crumbs() {
    members_.assign(planes_.size(), {});
    for (std::uint32_t t = 0; t < chart_of_.size(); ++t) members_[chart_of_[t]].push_back(t);
    for (std::vector<std::uint32_t>& members : members_) {
      if (members.size() >= kCrumb) continue;
      for (const std::uint32_t t : members) chart_of_[t] = kNone;
      members.clear();
    }
  }

  /// Without the charts that have no triangles.
  void renumber() {
    std::vector<std::uint32_t> number(planes_.size(), kNone);
    for (const std::uint32_t chart : chart_of_) number[chart] = 0;
    std::vector<ChartPlane> kept;
    for (std::size_t chart = 0; chart < planes_.size(); ++chart) {
      if (number[chart] == kNone) continue;
      number[chart] = static_cast<std::uint32_t>(kept.size());
      kept.push_back(planes_[chart]);
    }
    for (std::uint32_t& chart : chart_of_) chart = number[chart];
    planes_ = std::move(kept);
  }

  const Mesh& mesh_;
  double texel_;
  int max_side_;
  std::vector<Neighbours> neighbours_;
  std::vector<Eigen::Vector3f> normals_;
  std::vector<std::uint32_t> chart_of_;
  std::vector<ChartPlane> planes_;
  std::vector<std::vector<std::uint32_t>> members_;  ///< of the charts that are no crumbs
  std::vector<std::uint32_t> was_looked_at_;         ///< in which look
  std::uint32_t look_ = 0;
  CoveredTexels covered_;
  Extent extent_;
};

}  // namespace

Charts grow_charts(const Mesh& mesh, double texel, int max_side) {
  SCANKNIT_CHECK(texel > 0 && max_side >= 1 && max_side <= 2048);
  return ChartGrower(mesh, texel, max_side).grow();
}

}  // namespace scanknit
