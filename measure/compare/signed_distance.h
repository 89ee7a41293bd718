// SignedDistance: on which side of a mesh a point lies, and how far from it.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/mesh.h"
#include "measure/tree/pseudonormals.h"
#include "measure/tree/triangle_bvh.h"

namespace scanknit {

/// Refers to the mesh, which must be well formed, have a triangle, and outlive it. Safe to read from many threads.
class SignedDistance {
 public:
  explicit SignedDistance(const Mesh& mesh);

  /// Positive outside of a closed mesh, and before the front of an open one. Exact.
  [[nodiscard]] double at(const Eigen::Vector3d& p) const;
  /// The same of many points, with all threads.
  [[nodiscard]] std::vector<double> at(std::span<const Eigen::Vector3d> points) const;

  /// The mesh is closed, and its triangles are clockwise seen from outside; at() takes that into account.
  [[nodiscard]] bool is_inside_out() const { return is_inside_out_; }
  [[nodiscard]] const EdgeCounts& edges() const { return edges_; }
  [[nodiscard]] const TriangleBvh& tree() const { return tree_; }
  [[nodiscard]] const Pseudonormals& normals() const { return normals_; }

 private:
  [[nodiscard]] double signed_distance(const Eigen::Vector3d& p, const NearestOnMesh& foot) const;

  TriangleBvh tree_;
  Pseudonormals normals_;
  EdgeCounts edges_;
  bool is_inside_out_ = false;
};

}  // namespace scanknit
