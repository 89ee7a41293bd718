// VertexSampler: computes the position of a vertex on its grid edge, and its normal and colour.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>

#include "core/image.h"
#include "extract/blocks/block.h"
#include "extract/cell/cell.h"
#include "extract/cell/triangulate_cell.h"
#include "extract/extract_config.h"

namespace scanknit {

/// A grid edge: from the voxel `low` (block coordinates) one step along `axis`.
struct GridEdge {
  Eigen::Vector3i low;
  int axis;
};

/// Edge `edge` of the cell at `cell`.
[[nodiscard]] inline GridEdge grid_edge(const Eigen::Vector3i& cell, int edge) {
  const int low = edge_low_corner(edge);
  const Eigen::Vector3i offset(corner_coordinate(low, 0), corner_coordinate(low, 1), corner_coordinate(low, 2));
  return {cell + offset, edge_axis(edge)};
}

struct SurfaceVertex {
  Eigen::Vector3d p_world;
  Eigen::Vector3d outward;  ///< unit; zero if the gradient is unusable or normals are off
  Eigen::Vector3d colour;   ///< sRGB-encoded, 0 to 1

  [[nodiscard]] Rgb8 rgb() const;
};

/// The values that all blocks share.
struct SamplingFrame {
  SamplingFrame(const Eigen::Affine3d& world_from_index, bool is_inside_high);

  Eigen::Affine3d T_world_index;
  Eigen::Matrix3d outward_from_gradient;  ///< a gradient in index coordinates to an outward vector in the world
  Eigen::Vector3d edge_length;            ///< of the grid edges along each axis, world
};

/// Refers to one loaded block, which must outlive it.
class VertexSampler {
 public:
  /// `colours` may be null; then the resulting colours are undefined.
  VertexSampler(const ValueBlock& values, const ColourBlock* colours, const Eigen::Vector3i& origin,
                const SamplingFrame& frame, const ExtractConfig& config);

  /// Writes only the positions of the vertices on the block's own edges along `axis` whose bits are set, in order of x,
  /// y, z. Gives the same bits as on_edge(), many times faster; almost all vertices are computed by it. Returns their
  /// number.
  std::size_t write_positions(int axis, const VoxelBits& edges, Eigen::Vector3f* p_world) const;

  /// The vertex on an edge with one High and one Low end.
  [[nodiscard]] SurfaceVertex on_edge(const GridEdge& edge) const;

  /// The interior vertex, near the mean of the vertices on these edges of a cell.
  [[nodiscard]] SurfaceVertex inside_cell(const Eigen::Vector3i& cell, EdgeMask edges) const;

 private:
  [[nodiscard]] double margin(const Eigen::Vector3i& owner, int axis) const;

  [[nodiscard]] double parameter(const GridEdge& edge) const;
  [[nodiscard]] Eigen::Vector3d p_world(const GridEdge& edge, double t) const;
  [[nodiscard]] Eigen::Vector3d gradient(const Eigen::Vector3i& voxel) const;
  [[nodiscard]] Eigen::Vector3d outward(const GridEdge& edge, double t) const;
  [[nodiscard]] Eigen::Vector3d colour(const GridEdge& edge, double t) const;

  const ValueBlock& values_;
  const ColourBlock* colours_;
  Eigen::Vector3i origin_;
  const SamplingFrame& frame_;
  const ExtractConfig& config_;
  Eigen::Vector3d margins_;  ///< least distances from the ends, for the block's own edges along each axis
};

}  // namespace scanknit
