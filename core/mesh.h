// Mesh: an indexed triangle mesh, and a check of its topology.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/image.h"

namespace scanknit {

/// Three vertices of a mesh. Uninitialised by default, unlike std::array's elements in a vector: code allocates
/// millions of them before it writes them.
struct Triangle : std::array<std::uint32_t, 3> {
  Triangle() {}  // NOLINT: not defaulted, because vector::resize would write zeros then
  Triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) : std::array<std::uint32_t, 3>{a, b, c} {}
};
static_assert(sizeof(Triangle) == 12);

}  // namespace scanknit

// const auto& [a, b, c] = triangle
template <>
struct std::tuple_size<scanknit::Triangle> : std::tuple_size<std::array<std::uint32_t, 3>> {};
template <std::size_t I>
struct std::tuple_element<I, scanknit::Triangle> : std::tuple_element<I, std::array<std::uint32_t, 3>> {};

namespace scanknit {

/// Positions in metres in the world frame; triangles counter-clockwise seen from outside. `normals` (unit) and
/// `colours` (sRGB) are either empty or as long as `positions_m`. Every index is below positions_m.size().
struct Mesh {
  std::vector<Eigen::Vector3f> positions_m;
  std::vector<Eigen::Vector3f> normals;
  std::vector<Rgb8> colours;
  std::vector<Triangle> triangles;

  [[nodiscard]] bool empty() const { return triangles.empty(); }
};

/// Counts of a mesh as a simplicial complex. `euler` and `components` ignore unreferenced vertices.
struct MeshCheck {
  std::size_t vertices = 0;
  std::size_t triangles = 0;
  std::size_t components = 0;             ///< sets of triangles connected by shared vertices
  std::size_t boundary_edges = 0;         ///< edges of one triangle
  std::size_t non_manifold_edges = 0;     ///< edges of three or more triangles
  std::size_t misoriented_edges = 0;      ///< edges of two triangles with the same direction on it
  std::size_t non_manifold_vertices = 0;  ///< vertices whose triangles form more than one fan
  std::size_t degenerate_triangles = 0;   ///< without area: corners at the same position, or collinear
  std::size_t duplicate_triangles = 0;    ///< the same three vertices again
  std::size_t unreferenced_vertices = 0;
  long long euler = 0;         ///< vertices - edges + triangles
  bool is_well_formed = true;  ///< indices in range, attribute lengths right, every number finite
  Eigen::Vector3f min_m = Eigen::Vector3f::Zero();
  Eigen::Vector3f max_m = Eigen::Vector3f::Zero();

  [[nodiscard]] bool is_closed() const { return triangles > 0 && boundary_edges == 0; }
  [[nodiscard]] bool is_manifold() const {
    return non_manifold_edges == 0 && non_manifold_vertices == 0 && misoriented_edges == 0;
  }
};

/// O(n log n). For a mesh that is not well formed, counts only vertices and triangles.
[[nodiscard]] MeshCheck check_mesh(const Mesh& mesh);

/// Signed volume by the divergence theorem, cubic metres; positive when triangles are counter-clockwise from outside.
/// Meaningful for closed meshes.
[[nodiscard]] double signed_volume_m3(const Mesh& mesh);

/// Removes every component of fewer than `min_triangles` triangles, and the vertices that no triangle uses. The order
/// of the rest is unchanged. Returns the number of components removed.
std::size_t remove_small_components(Mesh& mesh, std::size_t min_triangles);

}  // namespace scanknit
