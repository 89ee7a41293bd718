// Pseudonormals: normals that distinguish outside from inside at the nearest point of a mesh.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh.h"
#include "measure/tree/triangle_bvh.h"

namespace scanknit {

/// How the triangles meet at the edges of a mesh.
struct EdgeCounts {
  std::size_t border = 0;   ///< edges of one triangle
  std::size_t tangled = 0;  ///< edges of three or more triangles, or of two that run along it in the same direction
};

/// The angle-weighted pseudonormals of Baerentzen & Aanaes 2005, "Signed Distance Computation Using the Angle Weighted
/// Pseudonormal". Right for a closed mesh; beside an open one they say before which side a point lies. Refers to the
/// mesh, which must be well formed and outlive it. Safe to read from many threads.
class Pseudonormals {
 public:
  explicit Pseudonormals(const Mesh& mesh);

  /// The unit normal; zero for a triangle without area.
  [[nodiscard]] Eigen::Vector3d face(std::uint32_t triangle) const;

  /// Not of unit length.
  [[nodiscard]] Eigen::Vector3d at(std::uint32_t triangle, TriangleFeature feature) const;

  [[nodiscard]] EdgeCounts count_edges() const;

 private:
  [[nodiscard]] std::span<const std::uint32_t> triangles_at(std::uint32_t vertex) const;
  [[nodiscard]] Eigen::Vector3d at_edge(std::uint32_t from, std::uint32_t to) const;
  [[nodiscard]] Eigen::Vector3d at_vertex(std::uint32_t vertex) const;

  const Mesh& mesh_;
  std::vector<std::uint32_t> first_;      ///< by vertex: the first of its triangles in triangles_
  std::vector<std::uint32_t> triangles_;  ///< of each vertex, ascending
};

}  // namespace scanknit
