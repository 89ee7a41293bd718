// TriangleBvh: finds the nearest point and the first hit on a triangle mesh.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/mesh.h"
#include "measure/tree/ray.h"

namespace scanknit {

/// The part of a triangle that contains a nearest point.
enum class TriangleFeature : std::uint8_t { kVertex0, kVertex1, kVertex2, kEdge01, kEdge12, kEdge20, kFace };

struct NearestOnMesh {
  double distance_m = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  std::uint32_t triangle = 0;
  TriangleFeature feature = TriangleFeature::kFace;
};

struct MeshHit {
  double t_m;
  std::uint32_t triangle;
};

/// A bounding volume hierarchy, split at the median of the longest axis; the same mesh gives the same tree. Refers to
/// the mesh, which must be well formed, have a triangle, and outlive it.
class TriangleBvh {
 public:
  explicit TriangleBvh(const Mesh& mesh);

  /// The nearest point of the mesh, or nothing when it is farther than `max_distance_m`.
  [[nodiscard]] std::optional<NearestOnMesh> nearest(const Eigen::Vector3d& p, double max_distance_m) const;

  /// The first triangle hit, from either side, with 0 < t <= max_t_m. No ray passes through a shared edge.
  [[nodiscard]] std::optional<MeshHit> intersect(const Ray& ray, double max_t_m) const;

 private:
  struct Node {
    Eigen::AlignedBox3f box;
    std::uint32_t first = 0;  // leaf: first entry of order_; inner: its second child (the first is the next node)
    std::uint32_t count = 0;  // leaf: triangles; inner: 0
  };
  struct Corners {
    Eigen::Vector3d a, b, c;
  };
  void build(std::uint32_t begin, std::uint32_t end, const std::vector<Eigen::Vector3f>& centres);
  [[nodiscard]] Corners corners(std::uint32_t triangle) const;

  const Mesh& mesh_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace scanknit
