// Computes many vertices on a block's grid edges of one axis at once.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <span>

#include "extract/blocks/block.h"

namespace scanknit {

/// Grid edges along one axis that cross the isovalue, at most one for each of a block's voxels. It has one array for
/// each quantity, for vector instructions.
class CrossingEdges {
 public:
  static constexpr std::size_t kMax = std::size_t{kBlockCells} * kBlockCells * kBlockCells;

  /// The edge from the voxel (x, y, z), 0 to 7 each, between samples `low` and `high`.
  void push_back(int x, int y, int z, float low, float high) {
    offset_[0][size_] = static_cast<float>(x);
    offset_[1][size_] = static_cast<float>(y);
    offset_[2][size_] = static_cast<float>(z);
    low_[size_] = low;
    high_[size_] = high;
    ++size_;
  }
  [[nodiscard]] std::size_t size() const { return size_; }
  void clear() { size_ = 0; }

  [[nodiscard]] const float* offset(std::size_t axis) const { return offset_[axis].data(); }
  [[nodiscard]] const float* low() const { return low_.data(); }
  [[nodiscard]] const float* high() const { return high_.data(); }

 private:
  using Column = std::array<float, kMax>;
  std::size_t size_ = 0;
  alignas(64) std::array<Column, 3> offset_;  // not initialised
  alignas(64) Column low_;
  alignas(64) Column high_;
};

/// The values that all edges of a block share.
struct CrossingFrame {
  int axis;
  double isovalue;
  double margin;           ///< least distance from either end, as a share of the edge; 0.5: the middle of the edge
  Eigen::Vector3d origin;  ///< of the block, in index coordinates
  const Eigen::Affine3d& T_world_index;
};

/// Computes one point in the world for each edge: the zero of the linear interpolant, at least `margin` away from the
/// ends. Chooses the widest instructions of the processor at run time; each operation is rounded as IEEE 754 says and
/// none are fused, so all give the same bits, and the same as VertexSampler::on_edge.
void crossing_points(const CrossingEdges& edges, const CrossingFrame& frame, std::span<Eigen::Vector3f> p_world);

}  // namespace scanknit
