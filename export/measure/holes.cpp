#include "export/measure/holes.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <utility>

namespace scanknit {
namespace {

struct DirectedEdge {
  std::uint32_t from, to;

  [[nodiscard]] std::uint32_t low() const { return std::min(from, to); }
  [[nodiscard]] std::uint32_t high() const { return std::max(from, to); }
};

/// The edges whose lower vertex is one of first ... last - 1, sorted by that vertex, then by the other one.
std::vector<DirectedEdge> sorted_edges(const Mesh& mesh, std::size_t first, std::size_t last) {
  const auto for_each_edge = [&](const auto& visit) {
    for (const Triangle& t : mesh.triangles) {
      for (std::size_t i = 0; i < 3; ++i) {
        const DirectedEdge edge{t[i], t[(i + 1) % 3]};
        if (edge.low() >= first && edge.low() < last) visit(edge);
      }
    }
  };
  std::vector<std::size_t> next(last - first + 1, 0);
  for_each_edge([&](const DirectedEdge& edge) { ++next[edge.low() - first + 1]; });
  std::partial_sum(next.begin(), next.end(), next.begin());
  std::vector<DirectedEdge> edges(next.back());
  for_each_edge([&](const DirectedEdge& edge) { edges[next[edge.low() - first]++] = edge; });
  std::size_t begin = 0;
  for (std::size_t vertex = 0; vertex + 1 < next.size(); ++vertex) {
    const std::size_t end = next[vertex];
    std::sort(edges.begin() + static_cast<std::ptrdiff_t>(begin), edges.begin() + static_cast<std::ptrdiff_t>(end),
              [](const DirectedEdge& a, const DirectedEdge& b) { return a.high() < b.high(); });
    begin = end;
  }
  return edges;
}

/// Those of one triangle only, sorted by where they begin.
std::vector<DirectedEdge> boundary_edges(const Mesh& mesh) {
  constexpr std::size_t kVerticesAtOnce = 1 << 18;  // 14 MiB
  const auto is_same = [](const DirectedEdge& a, const DirectedEdge& b) {
    return a.low() == b.low() && a.high() == b.high();
  };
  std::vector<DirectedEdge> lonely;
  for (std::size_t first = 0; first < mesh.positions_m.size(); first += kVerticesAtOnce) {
    const auto edges = sorted_edges(mesh, first, std::min(first + kVerticesAtOnce, mesh.positions_m.size()));
    for (std::size_t i = 0; i < edges.size();) {
      std::size_t next = i + 1;
      while (next < edges.size() && is_same(edges[next], edges[i])) ++next;
      if (next == i + 1) lonely.push_back(edges[i]);
      i = next;
    }
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
