#include "export/tiles/simplify_tile.h"

#include <meshoptimizer.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <utility>

#include "core/mesh/split_mesh.h"
#include "core/mesh/triangle_fins.h"

namespace scanknit {
namespace {

using Number = std::uint32_t;

constexpr float kAnyErrorOfATile = 1e3F;    // no limit, in extents of the tile; its square must fit into a float
constexpr double kReliefOfWhite = 0.5;      // in edges: more would fold the surface at sharp patterns
constexpr std::size_t kLockedOfAGroup = 4;  // whose triangles share an edge beside the tile

/// The triangles of a tile as meshoptimizer takes them: a part of the mesh, with the positions of its vertices.
struct LocalTile : MeshPart {
  std::vector<Eigen::Vector3f> positions;  ///< relief_of() them, and those of vertices that only serve as locks
};

double mean_edge(const Mesh& mesh, const std::vector<Triangle>& triangles) {
  double sum = 0;
  for (const Triangle& t : triangles) {
    sum += static_cast<double>((mesh.positions_m[t[1]] - mesh.positions_m[t[0]]).norm());
  }
  return sum / static_cast<double>(triangles.size());
}

/// 0 for black, 1 for white (the luma of ITU-R BT.601, of the bytes as they are: as bright as they look).
float brightness(Rgb8 c) {
  return (0.299F * static_cast<float>(c.r) + 0.587F * static_cast<float>(c.g) + 0.114F * static_cast<float>(c.b)) / 255;
}

/// The positions of the tile's vertices, for the simplifier, which knows no colours: they rise above the surface by
/// their brightness. So it keeps patterns of flat walls as it keeps shapes, and its error counts them.
std::vector<Eigen::Vector3f> relief_of(const Mesh& mesh, const std::vector<Number>& vertices, double edge) {
  const bool has_relief = !mesh.normals.empty() && !mesh.colours.empty();
  std::vector<Eigen::Vector3f> positions;
  positions.reserve(vertices.size());
  for (const Number v : vertices) {
    positions.push_back(mesh.positions_m[v]);
    if (!has_relief) continue;
    positions.back() += static_cast<float>(kReliefOfWhite * edge) * brightness(mesh.colours[v]) * mesh.normals[v];
  }
  return positions;
}

/// meshoptimizer 0.18 can lock all vertices of borders or none. A scan's own borders, round its holes, are to be
/// simplified, those towards other tiles are not. But it never moves a vertex from which two border edges start: so two
/// triangles are attached to each locked vertex, whose other corners, beside the tile, are locked for the same reason.
void attach_locks(const std::vector<Number>& locked, LocalTile& tile) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : tile.positions) box.extend(p);
  const std::size_t groups = (locked.size() + kLockedOfAGroup - 1) / kLockedOfAGroup;
  constexpr std::size_t kRow = 256;
  const auto rows = static_cast<float>(2 * groups / kRow + 1);
  const float side = std::max(box.sizes().maxCoeff(), 1e-6F);
  const auto add_vertex = [&] {  // on a square beside the box, at a place of its own
    const std::size_t n = tile.positions.size() - tile.vertices.size();
    const float along = static_cast<float>(n % kRow) / kRow, across = static_cast<float>(n / kRow) / rows;
    tile.positions.push_back(box.max() + side * Eigen::Vector3f(0.25F, along, across));
    return static_cast<Number>(tile.positions.size() - 1);
  };
  for (std::size_t first = 0; first < locked.size(); first += kLockedOfAGroup) {
    const Number a = add_vertex(), b = add_vertex();
    const std::size_t last = std::min(first + kLockedOfAGroup, locked.size());
    for (std::size_t i = first; i < last; ++i) tile.triangles.insert(tile.triangles.end(), 2, {locked[i], a, b});
  }
}

}  // namespace

CoarseTile simplify_tile(const Mesh& mesh, std::vector<Triangle> fine, std::size_t target,
                         const std::function<bool(std::uint32_t)>& is_locked) {
  LocalTile tile{part_of(fine), {}};
  tile.positions = relief_of(mesh, tile.vertices, mean_edge(mesh, fine));
  std::vector<Number> locked;
  for (Number v = 0; v < tile.vertices.size(); ++v) {
    if (is_locked(tile.vertices[v])) locked.push_back(v);
  }
  attach_locks(locked, tile);
  const std::size_t wanted = 3 * (target + tile.triangles.size() - fine.size());
  const std::size_t vertices = tile.positions.size();
  constexpr std::size_t kStep = sizeof(Eigen::Vector3f);
  float error = 0;
  std::vector<Triangle> fewer(tile.triangles.size());
  const std::size_t indices =
      meshopt_simplify(fewer.front().data(), tile.triangles.front().data(), 3 * tile.triangles.size(),
                       tile.positions.front().data(), vertices, kStep, wanted, kAnyErrorOfATile, 0, &error);
  fewer.resize(indices / 3);
  CoarseTile coarse;
  coarse.error = static_cast<double>(error) *
                 static_cast<double>(meshopt_simplifyScale(tile.positions.front().data(), vertices, kStep));
  const auto is_lock = [&](const Triangle& t) { return std::max({t[0], t[1], t[2]}) >= tile.vertices.size(); };
  for (const Triangle& t : fewer) {
    if (is_lock(t)) continue;
    coarse.triangles.emplace_back(tile.vertices[t[0]], tile.vertices[t[1]], tile.vertices[t[2]]);
  }
  remove_fins(coarse.triangles);
  if (coarse.triangles.empty()) return {std::move(fine), 0};
  return coarse;
}

}  // namespace scanknit
