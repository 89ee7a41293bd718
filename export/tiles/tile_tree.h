// TileTree: divides the triangles of a mesh among the cubes of an octree.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/mesh.h"

namespace scanknit {

struct TileNode {
  std::string name;  ///< "r" for the root, then a digit for each octant on the way: bit 0 is the upper half of x
  std::span<const std::uint32_t> triangles;  ///< the mesh's numbers of them, of all leaves below; a leaf's ascend
  std::uint32_t first_leaf = 0, leaves_before = 0;  ///< the leaves below it are first_leaf ... leaves_before - 1
  std::vector<TileNode> children;                   ///< none: a leaf; else at least two
};

/// Every triangle is in one leaf as a whole: that of its centroid. Cubes without triangles are left out, and so are
/// those with a single child. Needs 4 bytes for each triangle and 8 for each vertex.
class TileTree {
 public:
  /// `mesh` is well formed and has triangles. Leaves have at most `most_triangles`, or more where so many have
  /// centroids that cannot be told apart.
  TileTree(const Mesh& mesh, std::size_t most_triangles);

  [[nodiscard]] const TileNode& root() const { return root_; }

  /// True if leaves inside and outside of `node` use the vertex.
  [[nodiscard]] bool is_shared(std::uint32_t vertex, const TileNode& node) const {
    return first_leaf_[vertex] < node.first_leaf || last_leaf_[vertex] >= node.leaves_before;
  }

 private:
  struct Cube {
    Eigen::Vector3d centre_m;
    double half_m;
  };
  /// Fills `node`, whose name is given.
  void divide(std::span<std::uint32_t> triangles, Cube cube, TileNode& node);
  [[nodiscard]] std::size_t octant_of(std::uint32_t triangle, const Cube& cube) const;
  void close_leaf(TileNode& node);

  const Mesh& mesh_;
  std::size_t most_triangles_;
  std::vector<std::uint32_t> triangles_;
  std::vector<std::uint32_t> first_leaf_, last_leaf_;  ///< of each vertex
  std::uint32_t leaves_ = 0;
  TileNode root_;
};

}  // namespace scanknit
