#include "extract/split_pinches.h"

#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "core/mesh/disjoint_sets.h"

namespace scanknit {
namespace {

/// Where triangles use a vertex: 3 * triangle + position.
using Corner = std::size_t;

/// The corners at each vertex, in the order of the triangles: vertex v has corners[begin[v]] to corners[begin[v + 1]].
struct CornersOfVertices {
  std::vector<std::size_t> begin;
  std::vector<Corner> corners;

  explicit CornersOfVertices(const Mesh& mesh)
      : begin(mesh.positions_m.size() + 2, 0), corners(3 * mesh.triangles.size()) {
    for (const Triangle& t : mesh.triangles) {
      for (const std::uint32_t v : t) ++begin[v + std::size_t{2}];
    }
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    for (Corner c = 0; c < corners.size(); ++c) corners[begin[mesh.triangles[c / 3][c % 3] + std::size_t{1}]++] = c;
    begin.pop_back();  // begin[v + 1] has moved from the begin of v to its end
  }
};

/// Sorts the corners at one vertex after the other into fans. The mesh may have been split at the vertices before: a
/// split takes the triangles that share an edge along together.
class FanFinder {
 public:
  explicit FanFinder(const Mesh& mesh) : mesh_(mesh) {}

  /// The fans of the corners at a vertex, by their places: the root of a fan is its first corner.
  [[nodiscard]] DisjointSets& fans(std::span<const Corner> corners) {
    seen_.resize(mesh_.positions_m.size());  // copies have been appended since
    fans_.reset(corners.size());
    for (std::uint32_t i = 0; i < corners.size(); ++i) {
      const Triangle& t = mesh_.triangles[corners[i] / 3];
      for (const std::size_t step : {1u, 2u}) {
        Seen& seen = seen_[t[(corners[i] + step) % 3]];  // the vertex at the other end of an edge
        if (seen.begin == corners.data())
          fans_.join(seen.place, i);
        else
          seen = {corners.data(), i};
      }
    }
    return fans_;
  }

 private:
  /// The first corner that looked at a vertex, among the corners that begin there.
  struct Seen {
    const Corner* begin = nullptr;
    std::uint32_t place = 0;
  };
  const Mesh& mesh_;
  std::vector<Seen> seen_;
  DisjointSets fans_{0};
};

template <typename T>
void append_copy(std::vector<T>& attribute, std::size_t index) {
  if (attribute.empty()) return;
  const T copy = attribute[index];
  attribute.push_back(copy);
}

}  // namespace

std::size_t split_pinched_vertices(Mesh& mesh) {
  const std::size_t vertices = mesh.positions_m.size();
  const CornersOfVertices at(mesh);
  FanFinder finder(mesh);
  std::vector<std::uint32_t> vertex_of_fan;
  for (std::size_t v = 0; v < vertices; ++v) {
    const auto corners = std::span(at.corners).subspan(at.begin[v], at.begin[v + 1] - at.begin[v]);
    DisjointSets& fans = finder.fans(corners);
    vertex_of_fan.assign(corners.size(), static_cast<std::uint32_t>(v));
    for (std::uint32_t i = 1; i < corners.size(); ++i) {
      const std::uint32_t fan = fans.root(i);
      if (fan == 0) continue;
      if (fan == i) {
        vertex_of_fan[i] = static_cast<std::uint32_t>(mesh.positions_m.size());
        append_copy(mesh.positions_m, v);
        append_copy(mesh.normals, v);
        append_copy(mesh.colours, v);
      }
      mesh.triangles[corners[i] / 3][corners[i] % 3] = vertex_of_fan[fan];
    }
  }
  return mesh.positions_m.size() - vertices;
}

}  // namespace scanknit
