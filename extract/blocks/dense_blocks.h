// DenseBlocks: gives an array of samples as blocks.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "core/result.h"
#include "extract/blocks/block.h"
#include "extract/extract_surface.h"

namespace scanknit {

/// The blocks' z is i, the fastest axis in memory, and x is k, so that most blocks need no copy. The caller must keep
/// the view's samples alive.
class DenseBlocks final : public BlockSource {
 public:
  /// `first_k`, a multiple of 8: the index of the view's first slice, if the view is a part of a volume. kConfig: no
  /// sample along an axis, or more than 2^31 - 32; a transform that cannot be inverted or exceeds the range of a float.
  [[nodiscard]] static Result<DenseBlocks> open(const DenseView& view, int first_k = 0);

  [[nodiscard]] std::span<const Eigen::Vector3i> origins() const override { return origins_; }
  void classify(std::size_t first, float isovalue, std::span<BlockSigns> signs) const override;
  void load_values(std::size_t block, ValueBlock& values) const override;
  [[nodiscard]] const Eigen::Affine3d& T_world_index() const override { return T_world_index_; }

  /// The number of blocks in a layer of eight slices; the first layer has the view's first slice.
  [[nodiscard]] std::size_t blocks_per_layer() const { return blocks_per_layer_; }

 private:
  DenseBlocks(const DenseView& view, int first_k);
  void classify_run(const Eigen::Vector3i& origin, float isovalue, std::span<BlockSigns> signs) const;
  /// The sample at block coordinates, which must be within the array.
  [[nodiscard]] const float* sample(int x, int y, int z) const {
    return view_.samples + z +
           static_cast<std::ptrdiff_t>(view_.dims.x()) *
               (y + static_cast<std::ptrdiff_t>(view_.dims.y()) * (x - first_k_));
  }
  [[nodiscard]] bool contains(int x, int y) const {
    return x >= first_k_ && x - first_k_ < view_.dims.z() && y >= 0 && y < view_.dims.y();
  }

  DenseView view_;
  int first_k_;
  std::size_t blocks_per_layer_;
  Eigen::Affine3d T_world_index_;
  std::vector<Eigen::Vector3i> origins_;
};

}  // namespace scanknit
