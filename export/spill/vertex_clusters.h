// VertexClusters: simplifies a mesh of any size while it is streamed (Rossignac & Borrel 1993), for pictures.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "core/mesh.h"

namespace scanknit {

/// All vertices in a cube become one, at their mean. Add all vertices first, then all triangles.
class VertexClusters {
 public:
  /// `bounds` contains all vertices; its longest side is `cubes` (> 0) cubes long.
  VertexClusters(const Eigen::AlignedBox3f& bounds, int cubes);

  /// `normal` may be zero.
  void add_vertex(const Eigen::Vector3f& position, const Eigen::Vector3f& normal);
  /// The corners must be vertices that were added. Keeps the triangle if they are in three different cubes.
  void add_triangle(const std::array<Eigen::Vector3f, 3>& corners);

  [[nodiscard]] std::size_t size() const { return clusters_.size(); }

  /// The mesh, with normals and without duplicate triangles. Deterministic for the same order of vertices and
  /// triangles.
  [[nodiscard]] Mesh take();

 private:
  struct Cluster {
    Eigen::Vector3f sum_from_corner = Eigen::Vector3f::Zero();  ///< of positions minus the low corner of `bounds`
    Eigen::Vector3f normal_sum = Eigen::Vector3f::Zero();
    float vertices = 0;
  };
  [[nodiscard]] std::uint64_t cube_of(const Eigen::Vector3f& position) const;

  Eigen::Vector3f corner_;
  float cubes_per_metre_;
  std::unordered_map<std::uint64_t, std::uint32_t> index_of_cube_;
  std::vector<Cluster> clusters_;
  std::vector<Triangle> triangles_;  ///< each begins with its smallest corner
};

}  // namespace scanknit
