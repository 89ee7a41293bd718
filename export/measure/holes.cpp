#include "export/measure/holes.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cstdint>

namespace scanknit {
namespace {

struct DirectedEdge {
  std::uint32_t from, to;

  [[nodiscard]] std::uint64_t undirected() const {
    return static_cast<std::uint64_t>(std::min(from, to)) << 32 | std::max(from, to);
  }
};

/// Sorted by where they begin.
std::vector<DirectedEdge> boundary_edges(const Mesh& mesh) {
  std::vector<DirectedEdge> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) edges.push_back({t[i], t[(i + 1) % 3]});
  }
  tbb::parallel_sort(edges.begin(), edges.end(), [](const DirectedEdge& a, const DirectedEdge& b) {
    return std::pair(a.undirected(), a.from) < std::pair(b.undirected(), b.from);
  });
  std::vector<DirectedEdge> lonely;
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t next = i + 1;
    while (next < edges.size() && edges[next].undirected() == edges[i].undirected()) ++next;
    if (next == i + 1) lonely.push_back(edges[i]);
    i = next;
  }
  std::sort(lonely.begin(), lonely.end(), [](const DirectedEdge& a, const DirectedEdge& b) {
    return std::pair(a.from, a.to) < std::pair(b.from, b.to);
  });
  return lonely;
}

}  // namespace

std::vector<Hole> find_holes(const Mesh& mesh) {
  const std::vector<DirectedEdge> edges = boundary_edges(mesh);
  std::vector<bool> is_walked(edges.size(), false);
  const auto first_from = [&](std::uint32_t vertex) {
    const auto place = std::lower_bound(edges.begin(), edges.end(), vertex,
                                        [](const DirectedEdge& edge, std::uint32_t v) { return edge.from < v; });
    auto i = static_cast<std::size_t>(place - edges.begin());
    while (i < edges.size() && edges[i].from == vertex && is_walked[i]) ++i;
    return i < edges.size() && edges[i].from == vertex ? i : edges.size();
  };
  std::vector<Hole> holes;
  for (std::size_t begin = 0; begin < edges.size(); ++begin) {
    if (is_walked[begin]) continue;
    Hole hole;
    for (std::size_t i = begin; i < edges.size(); i = first_from(edges[i].to)) {
      is_walked[i] = true;
      ++hole.edges;
      const Eigen::Vector3d along =
          mesh.positions_m[edges[i].to].cast<double>() - mesh.positions_m[edges[i].from].cast<double>();
      hole.length_m += along.norm();
      if (edges[i].to == edges[begin].from) break;
    }
    holes.push_back(hole);
  }
  std::stable_sort(holes.begin(), holes.end(), [](const Hole& a, const Hole& b) { return a.length_m > b.length_m; });
  return holes;
}

}  // namespace scanknit
