// VertexClusters: a mesh of any size, coarsened as it comes by (Rossignac & Borrel 1993), to be looked at.
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

/// Cubes of one size; all vertices in a cube become one, their mean. First every vertex, then every triangle.
class VertexClusters {
 public:
  /// `bounds` holds every vertex; its longest side is `cubes` cubes long (> 0).
  VertexClusters(const Eigen::AlignedBox3f& bounds, int cubes);

  /// `normal` may be zero.
  void add_vertex(const Eigen::Vector3f& position, const Eigen::Vector3f& normal);
  /// Its corners are vertices that were added. Kept if they lie in three cubes.
  void add_triangle(const std::array<Eigen::Vector3f, 3>& corners);

  [[nodiscard]] std::size_t size() const { return clusters_.size(); }

  /// The mesh: no triangle twice; with normals. In the same order for the same order of vertices and triangles.
  [[nodiscard]] Mesh take();

 private:
  struct Cluster {
    Eigen::Vector3f sum_from_corner = Eigen::Vector3f::Zero();  ///< of positions, from the low corner of `bounds`
    Eigen::Vector3f normal_sum = Eigen::Vector3f::Zero();
    float vertices = 0;
  };
  [[nodiscard]] std::uint64_t cube_of(const Eigen::Vector3f& position) const;

  Eigen::Vector3f corner_;
  float cubes_per_metre_;
  std::unordered_map<std::uint64_t, std::uint32_t> index_of_cube_;
  std::vector<Cluster> clusters_;
  std::vector<Triangle> triangles_;  ///< beginning with their smallest corner
};

}  // namespace scanknit
