#include "export/spill/stitch_borders.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "core/mesh/disjoint_sets.h"

namespace scanknit {
namespace {

// A vertex has about six triangles; in a file made to waste time it has as many as it likes, each in its own part.
constexpr std::size_t kMostPartsOfAVertex = 32;
// Likewise, of borders that lie on one edge.
constexpr std::size_t kMostBordersTried = 16;

using Index = std::uint32_t;

/// An edge of one triangle, which is on its left.
struct BorderEdge {
  Index from, to;
  [[nodiscard]] std::pair<Index, Index> ends() const { return {std::min(from, to), std::max(from, to)}; }
};

struct Border {
  std::vector<Index> vertices;    ///< the mesh's numbers, ascending
  std::vector<BorderEdge> edges;  ///< between `vertices`, in the order of the triangles
};

/// SplitMix64's last step (Steele, Lea and Flood 2014): neighbours become numbers that have nothing in common.
std::uint64_t scrambled(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15u;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
  return x ^ (x >> 31);
}

/// Which of the vertices from `first_vertex` on are on a border, in one pass. An edge to a vertex and one from it add
/// up to nothing; by chance, in one of 2^64 cases, so does a border, which is then not joined.
std::vector<bool> are_on_border(const Mesh& mesh, std::size_t first_vertex, std::span<const Triangle> triangles) {
  std::vector<std::uint64_t> balance(mesh.positions_m.size() - first_vertex, 0);
  for (const Triangle& t : triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t from = t[i] - first_vertex, to = t[(i + 1) % 3] - first_vertex;
      balance[from] += scrambled(to);
      balance[to] -= scrambled(from);
    }
  }
  std::vector<bool> is_on_border(balance.size());
  for (std::size_t i = 0; i < balance.size(); ++i) is_on_border[i] = balance[i] != 0;
  return is_on_border;
}

/// Those that are alone between their two vertices.
std::vector<BorderEdge> without_pairs(const std::vector<BorderEdge>& edges) {
  std::vector<Index> order(edges.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](Index a, Index b) { return edges[a].ends() < edges[b].ends(); });
  std::vector<bool> is_alone(edges.size(), false);
  for (std::size_t i = 0, next = 0; i < order.size(); i = next) {
    for (next = i + 1; next < order.size() && edges[order[next]].ends() == edges[order[i]].ends();) ++next;
    is_alone[order[i]] = next == i + 1;
  }
  std::vector<BorderEdge> alone;
  for (std::size_t e = 0; e < edges.size(); ++e) {
    if (is_alone[e]) alone.push_back(edges[e]);
  }
  return alone;
}

Border border_of(const Mesh& mesh, std::size_t first_vertex, std::size_t first_triangle) {
  const auto triangles = std::span(mesh.triangles).subspan(first_triangle);
  const std::vector<bool> is_on_border = are_on_border(mesh, first_vertex, triangles);
  std::vector<BorderEdge> candidates;
  for (const Triangle& t : triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Index from = t[i], to = t[(i + 1) % 3];
      if (is_on_border[from - first_vertex] && is_on_border[to - first_vertex]) candidates.push_back({from, to});
    }
  }
  Border border;
  border.edges = without_pairs(candidates);
  std::vector<Index>& vertices = border.vertices;
  for (const BorderEdge& edge : border.edges) vertices.insert(vertices.end(), {edge.from, edge.to});
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  const auto place = [&](Index vertex) {
    return static_cast<Index>(std::lower_bound(vertices.begin(), vertices.end(), vertex) - vertices.begin());
  };
  for (BorderEdge& edge : border.edges) edge = {place(edge.from), place(edge.to)};
  return border;
}

/// What must be equal, bit by bit; but a zero has no sign.
using Attributes = std::array<Index, 9>;

template <typename Vector>
void put(const Vector& values, std::size_t at, Attributes& attributes) {
  for (const float value : values) attributes[at++] = std::bit_cast<Index>(value + 0.0f);
}

Attributes position_of(const Mesh& mesh, Index vertex) {
  Attributes attributes{};
  put(mesh.positions_m[vertex], 0, attributes);
  return attributes;
}

Attributes all_of(const Mesh& mesh, const AppendedParts& parts, Index vertex) {
  Attributes attributes = position_of(mesh, vertex);
  const std::size_t n = mesh.positions_m.size();
  if (mesh.normals.size() == n) put(mesh.normals[vertex], 3, attributes);
  if (mesh.colours.size() == n) {
    const Rgb8 c = mesh.colours[vertex];
    attributes[6] = static_cast<Index>(c.r << 16 | c.g << 8 | c.b);
  }
  if (!parts.coordinates.empty()) put(parts.coordinates[vertex - parts.first_vertex.front()], 7, attributes);
  return attributes;
}

/// A number for each of `attributes`, the same for equal ones.
std::vector<Index> kinds_of(const std::vector<Attributes>& attributes) {
  std::vector<Index> order(attributes.size()), kinds(attributes.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](Index a, Index b) { return attributes[a] < attributes[b]; });
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool is_new = i == 0 || attributes[order[i]] != attributes[order[i - 1]];
    kinds[order[i]] = is_new ? static_cast<Index>(i) : kinds[order[i - 1]];
  }
  return kinds;
}

/// Vertices of the border that become one.
class Joints {
 public:
  explicit Joints(std::size_t vertices) : sets_(vertices) {}
  /// Only vertices of different parts may become one; `part` is each vertex's.
  explicit Joints(std::vector<Index> part) : sets_(part.size()), part_(std::move(part)), next_(part_.size()) {
    std::iota(next_.begin(), next_.end(), 0u);
  }

  /// Both ends or none.
  bool join(const BorderEdge& a, const BorderEdge& b) {
    if (!may_join(a.from, b.to) || !may_join(a.to, b.from)) return false;
    join(a.from, b.to);
    join(a.to, b.from);
    return true;
  }
  [[nodiscard]] Index root(Index vertex) { return sets_.root(vertex); }

 private:
  void join(Index a, Index b) {
    if (sets_.root(a) == sets_.root(b)) return;
    sets_.join(a, b);
    if (!part_.empty()) std::swap(next_[a], next_[b]);  // two rings become one
  }

  [[nodiscard]] std::vector<Index> parts_in_ring(Index vertex) const {
    std::vector<Index> parts = {part_[vertex]};
    for (Index at = next_[vertex]; at != vertex; at = next_[at]) parts.push_back(part_[at]);
    return parts;
  }

  [[nodiscard]] bool may_join(Index a, Index b) {
    if (part_.empty() || sets_.root(a) == sets_.root(b)) return true;
    std::vector<Index> parts = parts_in_ring(a);
    const std::vector<Index> others = parts_in_ring(b);
    parts.insert(parts.end(), others.begin(), others.end());
    std::sort(parts.begin(), parts.end());
    return parts.size() <= kMostPartsOfAVertex && std::adjacent_find(parts.begin(), parts.end()) == parts.end();
  }

  DisjointSets sets_;
  std::vector<Index> part_;
  std::vector<Index> next_;  ///< rings of the vertices that are one
};

/// Finds each edge one of the same kinds that runs the other way. Those come first of which there is but one; from them
/// on both borders are followed like a zip, which also tells apart what lies on one point or edge (a file that rounds
/// positions has much of that). What is left after that is joined in its order.
class Zip {
 public:
  /// `kinds`: of each vertex, the same for those that may be one. All references outlive it.
  Zip(const Border& border, const std::vector<Index>& kinds, Joints& joints)
      : edges_(border.edges),
        kinds_(kinds),
        joints_(joints),
        is_joined_(edges_.size(), false),
        out_(border.vertices.size(), kNone),
        in_(border.vertices.size(), kNone) {
    for (Index e = 0; e < edges_.size(); ++e) {
      out_[edges_[e].from] = out_[edges_[e].from] == kNone ? e : kSeveral;
      in_[edges_[e].to] = in_[edges_[e].to] == kNone ? e : kSeveral;
    }
  }

  void close() {
    std::vector<Index> order(edges_.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(),
                     [&](Index a, Index b) { return kind_of(a).ends() < kind_of(b).ends(); });
    for (const bool are_single : {true, false}) {
      if (!are_single) join_points();
      for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
        end = begin;
        while (end < order.size() && kind_of(order[end]).ends() == kind_of(order[begin]).ends()) ++end;
        join_group(std::span(order).subspan(begin, end - begin), are_single);
      }
    }
  }

  /// Edges that were joined with one of several that they could be joined with.
  [[nodiscard]] std::size_t guesses() const { return guesses_; }

 private:
  static constexpr Index kNone = ~0u, kSeveral = ~0u - 1;

  [[nodiscard]] BorderEdge kind_of(Index edge) const { return {kinds_[edges_[edge].from], kinds_[edges_[edge].to]}; }

  /// Edges between the same two kinds.
  void join_group(std::span<const Index> group, bool are_single) {
    std::vector<Index> ways[2];
    for (const Index edge : group) {
      const BorderEdge kind = kind_of(edge);
      if (!is_joined_[edge] && kind.from != kind.to) ways[kind.from < kind.to ? 0 : 1].push_back(edge);
    }
    std::vector<Index>& open = ways[1];
    if (are_single && (ways[0].size() != 1 || open.size() != 1)) return;
    for (const Index edge : ways[0]) {
      const auto tried = open.begin() + static_cast<std::ptrdiff_t>(std::min(open.size(), kMostBordersTried));
      const auto found = std::find_if(open.begin(), tried, [&](Index other) { return join(edge, other); });
      if (found == tried) continue;
      open.erase(found);
      if (!are_single) ++guesses_;
      follow();
    }
  }

  [[nodiscard]] bool join(Index edge, Index other) {
    if (edge == other || is_joined_[edge] || is_joined_[other] || !joints_.join(edges_[edge], edges_[other]))
      return false;
    is_joined_[edge] = is_joined_[other] = true;
    joined_.emplace_back(edge, other);
    return true;
  }

  /// From what was joined, to both sides.
  void follow() {
    while (!joined_.empty()) {
      const auto [edge, other] = joined_.back();
      joined_.pop_back();
      join_next(out_[edges_[edge].to], in_[edges_[other].from]);
      join_next(out_[edges_[other].to], in_[edges_[edge].from]);
    }
  }

  void join_next(Index out, Index in) {
    if (out >= kSeveral || in >= kSeveral) return;
    const BorderEdge a = kind_of(out), b = kind_of(in);
    if (a.from != b.to || a.to != b.from) return;
    if (a.from == a.to) {
      points_.emplace_back(out, in);
    } else {
      (void)join(out, in);
    }
  }

  /// Edges whose ends are of one kind lie on many others, where several borders meet: first those that are joined at
  /// both ends already.
  void join_points() {
    for (const bool are_sure : {true, false}) {
      for (std::size_t i = 0; i < points_.size(); ++i) {  // more are found on the way
        const auto [edge, other] = points_[i];
        const bool is_sure = joints_.root(edges_[edge].from) == joints_.root(edges_[other].to) &&
                             joints_.root(edges_[edge].to) == joints_.root(edges_[other].from);
        if ((!is_sure && are_sure) || !join(edge, other)) continue;
        if (!is_sure) ++guesses_;
        follow();
      }
    }
  }

  const std::vector<BorderEdge>& edges_;
  const std::vector<Index>& kinds_;
  Joints& joints_;
  std::vector<bool> is_joined_;
  std::vector<Index> out_, in_;  ///< the border edge from and to a vertex
  std::vector<std::pair<Index, Index>> joined_, points_;
  std::size_t guesses_ = 0;
};

/// Keeps the first of those that are one.
std::size_t remove_joined(const Border& border, Joints& joints, std::size_t first_vertex, std::size_t first_triangle,
                          Mesh& mesh) {
  const std::size_t n = mesh.positions_m.size();
  const bool has_normals = mesh.normals.size() == n, has_colours = mesh.colours.size() == n;
  std::vector<Index> number(n - first_vertex);
  std::size_t kept = first_vertex, place = 0;
  for (std::size_t v = first_vertex; v < n; ++v) {
    if (place < border.vertices.size() && border.vertices[place] == v) {
      const Index first = border.vertices[joints.root(static_cast<Index>(place++))];
      if (first != v) {
        number[v - first_vertex] = number[first - first_vertex];
        continue;
      }
    }
    number[v - first_vertex] = static_cast<Index>(kept);
    mesh.positions_m[kept] = mesh.positions_m[v];
    if (has_normals) mesh.normals[kept] = mesh.normals[v];
    if (has_colours) mesh.colours[kept] = mesh.colours[v];
    ++kept;
  }
  for (Triangle& t : std::span(mesh.triangles).subspan(first_triangle)) {
    for (Index& corner : t) corner = number[corner - first_vertex];
  }
  mesh.positions_m.resize(kept);
  if (has_normals) mesh.normals.resize(kept);
  if (has_colours) mesh.colours.resize(kept);
  return n - kept;
}

}  // namespace

std::size_t stitch_parts(Mesh& mesh, const AppendedParts& parts) {
  if (parts.first_vertex.size() < 2) return 0;
  const Border border = border_of(mesh, parts.first_vertex.front(), parts.first_triangle);
  std::vector<Attributes> attributes;
  std::vector<Index> part;
  for (const Index vertex : border.vertices) {
    attributes.push_back(all_of(mesh, parts, vertex));
    const auto after = std::upper_bound(parts.first_vertex.begin(), parts.first_vertex.end(), std::size_t{vertex});
    part.push_back(static_cast<Index>(after - parts.first_vertex.begin()));
  }
  Joints joints(std::move(part));
  const std::vector<Index> kinds = kinds_of(attributes);
  Zip(border, kinds, joints).close();
  return remove_joined(border, joints, parts.first_vertex.front(), parts.first_triangle, mesh);
}

StitchedSeams stitch_seams(Mesh& mesh) {
  const Border border = border_of(mesh, 0, 0);
  std::vector<Attributes> attributes;
  for (const Index vertex : border.vertices) attributes.push_back(position_of(mesh, vertex));
  Joints joints(border.vertices.size());
  const std::vector<Index> kinds = kinds_of(attributes);
  Zip zip(border, kinds, joints);
  zip.close();
  return {remove_joined(border, joints, 0, 0, mesh), zip.guesses()};
}

}  // namespace scanknit
