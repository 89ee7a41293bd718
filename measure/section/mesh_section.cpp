#include "measure/section/mesh_section.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

namespace scanknit {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// An edge of the mesh, by its vertices.
using EdgeKey = std::pair<std::uint32_t, std::uint32_t>;

/// A triangle's share of the outline: from one of its edges to another, with matter to the left.
struct CutSegment {
  EdgeKey from, to;
};

EdgeKey edge_between(std::uint32_t a, std::uint32_t b) {
  return {std::min(a, b), std::max(a, b)};
}

std::vector<double> heights_above(const Mesh& mesh, const SectionPlane& plane) {
  std::vector<double> heights_m;
  heights_m.reserve(mesh.positions_m.size());
  for (const Eigen::Vector3f& p : mesh.positions_m) {
    heights_m.push_back(plane.normal.dot(p.cast<double>()) - plane.offset_m);
  }
  return heights_m;
}

std::vector<CutSegment> segments_of(const Mesh& mesh, const std::vector<double>& heights_m) {
  std::vector<CutSegment> segments;
  for (const Triangle& t : mesh.triangles) {
    const std::array<bool, 3> is_above = {heights_m[t[0]] >= 0, heights_m[t[1]] >= 0, heights_m[t[2]] >= 0};
    CutSegment segment;
    int crossings = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t next = (k + 1) % 3;
      if (is_above[k] == is_above[next]) continue;
      // Counter-clockwise seen from outside: the outline enters where the triangle's border goes down.
      (is_above[k] ? segment.from : segment.to) = edge_between(t[k], t[next]);
      ++crossings;
    }
    if (crossings == 2) segments.push_back(segment);
  }
  std::sort(segments.begin(), segments.end(),
            [](const CutSegment& a, const CutSegment& b) { return std::pair(a.from, a.to) < std::pair(b.from, b.to); });
  return segments;
}

/// Chains of segments, each from where the one before it ends.
class SegmentChains {
 public:
  explicit SegmentChains(std::vector<CutSegment> segments)
      : segments_(std::move(segments)), is_walked_(segments_.size(), false) {}

  /// The edges that a chain visits; a closed one ends with its first.
  [[nodiscard]] std::vector<std::vector<EdgeKey>> chains() {
    std::vector<EdgeKey> ends;
    for (const CutSegment& segment : segments_) ends.push_back(segment.to);
    std::sort(ends.begin(), ends.end());
    std::vector<std::vector<EdgeKey>> chains;
    for (const bool only_beginnings : {true, false}) {  // first the open ones, each from its beginning
      for (std::size_t i = 0; i < segments_.size(); ++i) {
        if (is_walked_[i]) continue;
        if (only_beginnings && std::binary_search(ends.begin(), ends.end(), segments_[i].from)) continue;
        chains.push_back(walk_from(i));
      }
    }
    return chains;
  }

 private:
  std::vector<EdgeKey> walk_from(std::size_t begin) {
    std::vector<EdgeKey> chain = {segments_[begin].from};
    for (std::size_t i = begin; i < segments_.size(); i = next_from(segments_[i].to)) {
      is_walked_[i] = true;
      chain.push_back(segments_[i].to);
      if (segments_[i].to == chain.front()) break;
    }
    return chain;
  }

  [[nodiscard]] std::size_t next_from(const EdgeKey& edge) const {
    const auto first =
        std::lower_bound(segments_.begin(), segments_.end(), edge,
                         [](const CutSegment& segment, const EdgeKey& key) { return segment.from < key; });
    auto i = static_cast<std::size_t>(first - segments_.begin());
    while (i < segments_.size() && segments_[i].from == edge && is_walked_[i]) ++i;
    return i < segments_.size() && segments_[i].from == edge ? i : segments_.size();
  }

  std::vector<CutSegment> segments_;
  std::vector<bool> is_walked_;
};

/// The point where an edge meets the plane, in the drawing.
Vector2d crossing_of(const Mesh& mesh, const std::vector<double>& heights_m, const SectionPlane& plane,
                     const EdgeKey& edge) {
  const double low = heights_m[edge.first], high = heights_m[edge.second];  // of different signs: low - high is not 0
  const double share = low / (low - high);
  const Vector3d p =
      mesh.positions_m[edge.first].cast<double>() * (1 - share) + mesh.positions_m[edge.second].cast<double>() * share;
  return {plane.right.dot(p), plane.up.dot(p)};
}

Outline outline_of(const std::vector<Vector2d>& visited, bool is_closed) {
  Outline outline;
  outline.is_closed = is_closed;
  for (const Vector2d& p : visited) {
    if (outline.points_m.empty() || p != outline.points_m.back()) outline.points_m.push_back(p);
  }
  auto& points = outline.points_m;
  if (is_closed && points.size() > 1 && points.front() == points.back()) points.pop_back();
  const std::size_t sides = is_closed ? points.size() : points.size() - 1;
  for (std::size_t i = 0; i < sides; ++i) {
    const Vector2d a = points[i] - points[0], b = points[(i + 1) % points.size()] - points[0];
    outline.length_m += (b - a).norm();
    if (is_closed) outline.area_m2 += (a.x() * b.y() - a.y() * b.x()) / 2;
  }
  return outline;
}

}  // namespace

SectionPlane section_plane(const Vector3d& normal, double offset_m) {
  SectionPlane plane{normal, offset_m};
  const Vector3d across = Vector3d::UnitZ().cross(normal);
  constexpr double kUpright = 1e-9;
  if (across.norm() > kUpright) {
    plane.right = across.normalized();
    plane.up = normal.cross(plane.right);
  } else {
    plane.right = normal.z() > 0 ? Vector3d::UnitX() : Vector3d(-Vector3d::UnitX());
    plane.up = normal.cross(plane.right);
  }
  return plane;
}

MeshSection cut_mesh(const Mesh& mesh, const SectionPlane& plane) {
  MeshSection section;
  section.plane = plane;
  const std::vector<double> heights_m = heights_above(mesh, plane);
  SegmentChains chains(segments_of(mesh, heights_m));
  Eigen::AlignedBox2d box;
  for (const std::vector<EdgeKey>& chain : chains.chains()) {
    std::vector<Vector2d> visited;
    for (const EdgeKey& edge : chain) visited.push_back(crossing_of(mesh, heights_m, plane, edge));
    Outline outline = outline_of(visited, chain.front() == chain.back());
    if (outline.points_m.size() < 2) continue;  // the plane only touches the mesh there
    for (const Vector2d& p : outline.points_m) box.extend(p);
    section.length_m += outline.length_m;
    section.area_m2 += outline.area_m2;
    if (!outline.is_closed) ++section.open_outlines;
    section.outlines.push_back(std::move(outline));
  }
  std::stable_sort(section.outlines.begin(), section.outlines.end(),
                   [](const Outline& a, const Outline& b) { return a.length_m > b.length_m; });
  if (!box.isEmpty()) {
    section.min_m = box.min();
    section.max_m = box.max();
  }
  return section;
}

}  // namespace scanknit
