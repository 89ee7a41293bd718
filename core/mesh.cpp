#include "core/mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

#include "core/mesh/mesh_area.h"
#include "core/mesh/mesh_pieces.h"
#include "core/mesh/unused_vertices.h"

namespace scanknit {
namespace {

using Index = std::uint32_t;

/// Values grouped by a key in [first, last): a counting sort that keeps the order of insertion within a group.
template <typename Value>
class Groups {
 public:
  Groups(Index first, Index last) : first_(first), last_(last), begin_(std::size_t{last} - first + 2, 0) {}
  void count(Index key) {
    if (has(key)) ++begin_[key - first_ + std::size_t{2}];
  }
  void seal() {
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    values_.resize(begin_.back());
  }
  /// Moves begin_[key + 1] from the begin of the group to its end, which is where the next one begins.
  void put(Index key, Value value) {
    if (has(key)) values_[begin_[key - first_ + std::size_t{1}]++] = value;
  }
  [[nodiscard]] std::span<Value> of(Index key) {
    const std::size_t begin = begin_[key - first_];
    return std::span<Value>(values_).subspan(begin, begin_[key - first_ + std::size_t{1}] - begin);
  }

 private:
  [[nodiscard]] bool has(Index key) const { return key >= first_ && key < last_; }
  Index first_, last_;
  std::vector<std::size_t> begin_;
  std::vector<Value> values_;
};

/// Calls work(first, last) for parts of the mesh's vertices, one after the other, so that what is known of each of a
/// part's vertices takes little memory.
template <typename Work>
void for_each_part(const Mesh& mesh, const Work& work) {
  constexpr std::size_t kVertices = 1 << 20;
  const std::size_t vertices = mesh.positions_m.size();
  for (std::size_t first = 0; first < vertices; first += kVertices) {
    work(static_cast<Index>(first), static_cast<Index>(std::min(first + kVertices, vertices)));
  }
}

struct HalfEdge {
  Index other;     // the edge's larger vertex; the group's key is the smaller
  bool is_upward;  // runs from the smaller vertex to the larger
};

bool is_well_formed(const Mesh& mesh) {
  const std::size_t n = mesh.positions_m.size();
  const auto fits = [n](std::size_t length) { return length == 0 || length == n; };
  const auto is_finite = [](const Eigen::Vector3f& v) { return v.allFinite(); };
  return fits(mesh.normals.size()) && fits(mesh.colours.size()) &&
         std::all_of(mesh.triangles.begin(), mesh.triangles.end(),
                     [n](const Triangle& t) { return t[0] < n && t[1] < n && t[2] < n; }) &&
         std::all_of(mesh.positions_m.begin(), mesh.positions_m.end(), is_finite) &&
         std::all_of(mesh.normals.begin(), mesh.normals.end(), is_finite);
}

bool is_degenerate(const Mesh& mesh, const Triangle& t) {
  return area_vector_m2(mesh, t).isZero(0);
}

/// Counts the edges whose smaller vertex is in [first, last) into `check`; returns their number.
std::size_t check_edges(const Mesh& mesh, Index first, Index last, MeshCheck& check) {
  Groups<HalfEdge> edges(first, last);
  for (const Triangle& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i)
      edges.count(std::min(t[static_cast<std::size_t>(i)], t[static_cast<std::size_t>((i + 1) % 3)]));
  }
  edges.seal();
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Index a = t[i];
      const Index b = t[(i + 1) % 3];
      edges.put(std::min(a, b), {std::max(a, b), a < b});
    }
  }
  std::size_t count = 0;
  for (Index v = first; v < last; ++v) {
    const auto group = edges.of(v);
    std::sort(group.begin(), group.end(), [](const HalfEdge& a, const HalfEdge& b) { return a.other < b.other; });
    for (std::size_t i = 0; i < group.size();) {
      std::size_t uses = 0;
      std::size_t upward = 0;
      const Index other = group[i].other;
      for (; i < group.size() && group[i].other == other; ++i) {
        ++uses;
        upward += group[i].is_upward ? 1 : 0;
      }
      ++count;
      check.boundary_edges += uses == 1 ? 1 : 0;
      check.non_manifold_edges += uses > 2 ? 1 : 0;
      check.misoriented_edges += uses == 2 && upward != 1 ? 1 : 0;
    }
  }
  return count;
}

/// The number of fans (connected sets of triangles sharing edges at v) among the triangles round one vertex.
std::size_t count_fans(const Mesh& mesh, Index v, std::span<const Index> triangles) {
  struct Spoke {  // the edge from v to `other`, and which of the triangles has it
    Index other;
    Index triangle;
  };
  std::vector<Spoke> spokes;
  spokes.reserve(2 * triangles.size());
  for (Index i = 0; i < triangles.size(); ++i) {
    const Triangle& t = mesh.triangles[triangles[i]];
    const std::size_t at = t[0] == v ? 0 : t[1] == v ? 1 : 2;
    spokes.push_back({t[(at + 1) % 3], i});
    spokes.push_back({t[(at + 2) % 3], i});
  }
  // Sorted rather than compared pair by pair: the hub of a cone has as many triangles as a file cares to give it.
  std::sort(spokes.begin(), spokes.end(), [](const Spoke& a, const Spoke& b) { return a.other < b.other; });
  DisjointSets fans(triangles.size());
  for (std::size_t i = 1; i < spokes.size(); ++i) {
    if (spokes[i].other == spokes[i - 1].other) fans.join(spokes[i].triangle, spokes[i - 1].triangle);
  }
  return fans.sets();
}

void check_vertices(const Mesh& mesh, Index first, Index last, MeshCheck& check) {
  Groups<Index> around(first, last);
  for (const Triangle& t : mesh.triangles) {
    for (const Index v : t) around.count(v);
  }
  around.seal();
  for (Index i = 0; i < mesh.triangles.size(); ++i) {
    for (const Index v : mesh.triangles[i]) around.put(v, i);
  }
  std::vector<Triangle> sorted;
  for (Index v = first; v < last; ++v) {
    const auto triangles = around.of(v);
    if (triangles.empty()) {
      ++check.unreferenced_vertices;
      continue;
    }
    check.non_manifold_vertices += count_fans(mesh, v, triangles) > 1 ? 1 : 0;

    sorted.clear();
    for (const Index index : triangles) {
      Triangle t = mesh.triangles[index];
      std::sort(t.begin(), t.end());
      if (t[0] == v) sorted.push_back(t);  // each triangle is looked at from its smallest vertex only
    }
    std::sort(sorted.begin(), sorted.end());
    const auto unique_end = std::unique(sorted.begin(), sorted.end());
    check.duplicate_triangles += static_cast<std::size_t>(sorted.end() - unique_end);
  }
}

/// The number of pieces that were removed; their vertices stay.
std::size_t remove_small_pieces_of_triangles(Mesh& mesh, std::size_t min_triangles) {
  DisjointSets sets = pieces_of(mesh);
  std::vector<Index> size(mesh.positions_m.size(), 0);
  for (const Triangle& t : mesh.triangles) {
    Index& triangles = size[sets.root(t[0])];
    if (triangles < std::numeric_limits<Index>::max()) ++triangles;
  }
  const auto removed = static_cast<std::size_t>(
      std::count_if(size.begin(), size.end(), [&](Index n) { return n > 0 && n < min_triangles; }));
  if (removed > 0)
    std::erase_if(mesh.triangles, [&](const Triangle& t) { return size[sets.root(t[0])] < min_triangles; });
  return removed;
}

}  // namespace

MeshCheck check_mesh(const Mesh& mesh) {
  MeshCheck check;
  check.vertices = mesh.positions_m.size();
  check.triangles = mesh.triangles.size();
  check.is_well_formed = is_well_formed(mesh);
  if (!check.is_well_formed || mesh.positions_m.empty()) return check;

  check.min_m = check.max_m = mesh.positions_m.front();
  for (const Eigen::Vector3f& p : mesh.positions_m) {
    check.min_m = check.min_m.cwiseMin(p);
    check.max_m = check.max_m.cwiseMax(p);
  }
  std::size_t edges = 0;
  for_each_part(mesh, [&](Index first, Index last) { edges += check_edges(mesh, first, last, check); });
  for_each_part(mesh, [&](Index first, Index last) { check_vertices(mesh, first, last, check); });
  for (const Triangle& t : mesh.triangles) check.degenerate_triangles += is_degenerate(mesh, t) ? 1 : 0;

  const std::size_t used = check.vertices - check.unreferenced_vertices;
  check.euler = static_cast<long long>(used) - static_cast<long long>(edges) + static_cast<long long>(check.triangles);
  check.components = pieces_of(mesh).sets() - check.unreferenced_vertices;
  return check;
}

double signed_volume_m3(const Mesh& mesh) {
  double six_volumes = 0;
  for (const Triangle& t : mesh.triangles) {
    const Eigen::Vector3d a = mesh.positions_m[t[0]].cast<double>();
    const Eigen::Vector3d b = mesh.positions_m[t[1]].cast<double>();
    const Eigen::Vector3d c = mesh.positions_m[t[2]].cast<double>();
    six_volumes += a.dot(b.cross(c));
  }
  return six_volumes / 6;
}

std::size_t remove_small_components(Mesh& mesh, std::size_t min_triangles) {
  const std::size_t removed = remove_small_pieces_of_triangles(mesh, min_triangles);
  if (removed > 0) drop_unused_vertices(mesh);
  return removed;
}

}  // namespace scanknit
