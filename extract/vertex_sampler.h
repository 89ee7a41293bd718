// VertexSampler: where on its grid edge a vertex lies, and its normal and colour there.
#pragma once

#include <Eigen/Core>
#include <span>

#include "extract/block.h"
#include "extract/cell.h"
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
  Eigen::Vector3d outward;  ///< unit; zero where the gradient does not tell
  Eigen::Vector3d colour;   ///< sRGB-encoded, 0 to 1
};

/// Looks at one loaded block, which must outlive it.
class VertexSampler {
 public:
  struct Frame {
    double voxel_size_m;
    Eigen::Vector3d translation_m;
    bool inside_is_high;
  };

  /// `colours` may be null; then the colours that come out mean nothing.
  VertexSampler(const ValueBlock& values, const ColourBlock* colours, const Eigen::Vector3i& origin, const Frame& frame,
                const ExtractConfig& config)
      : values_(values), colours_(colours), origin_(origin), frame_(frame), config_(config) {}

  /// One end of `edge` is High, the other Low.
  [[nodiscard]] SurfaceVertex on_edge(const GridEdge& edge) const;

  /// The mean of a contour's vertices.
  [[nodiscard]] SurfaceVertex inside_cell(const Eigen::Vector3i& cell, std::span<const EdgeIndex> contour) const;

 private:
  [[nodiscard]] double parameter(const GridEdge& edge) const;
  [[nodiscard]] Eigen::Vector3d p_world(const GridEdge& edge, double t) const;
  [[nodiscard]] Eigen::Vector3d gradient(const Eigen::Vector3i& voxel) const;
  [[nodiscard]] Eigen::Vector3d outward(const GridEdge& edge, double t) const;
  [[nodiscard]] Eigen::Vector3d colour(const GridEdge& edge, double t) const;

  const ValueBlock& values_;
  const ColourBlock* colours_;
  Eigen::Vector3i origin_;
  const Frame& frame_;
  const ExtractConfig& config_;
};

}  // namespace scanknit
