// VdbBlocks: gives the leaves of an OpenVDB volume as blocks.
#pragma once

#include <openvdb/openvdb.h>

#include <vector>

#include "core/field_view.h"
#include "core/result.h"
#include "extract/blocks/block.h"

namespace scanknit {

/// The caller must keep the view's grids alive. Converts active tiles (constant regions that OpenVDB stores as one
/// value) to leaves in a copy of the field.
class VdbBlocks final : public BlockSource {
 public:
  /// kConfig: the transform is not linear and invertible, or the grids' transforms differ. kBudget: the active tiles
  /// have more than 2^31 voxels. Throws what OpenVDB and the allocator throw.
  [[nodiscard]] static Result<VdbBlocks> open(const FieldView& view, double min_weight);

  /// The same volume with a shorter list of blocks: those of `origins` (sorted by is_before) that have a leaf now. It
  /// still reads samples of all leaves. The time depends only on the number of `origins`.
  [[nodiscard]] VdbBlocks restricted_to(std::vector<Eigen::Vector3i> origins) const;

  [[nodiscard]] std::span<const Eigen::Vector3i> origins() const override { return origins_; }
  void classify(std::size_t first, float isovalue, std::span<BlockSigns> signs) const override;
  void load_values(std::size_t block, ValueBlock& values) const override;
  [[nodiscard]] bool has_colours() const override { return view_.colour != nullptr || view_.colour_codes != nullptr; }
  void load_colours(std::size_t block, ColourBlock& colours) const override;
  [[nodiscard]] const Eigen::Affine3d& T_world_index() const override { return T_world_index_; }

 private:
  VdbBlocks(const FieldView& view, double min_weight, const Eigen::Affine3d& T_world_index);

  FieldView view_;
  openvdb::FloatGrid::ConstPtr unfolded_;  // owns view_.field if it had active tiles
  float min_weight_;                       ///< the least weight above 0 that counts as observed
  Eigen::Affine3d T_world_index_;
  std::vector<Eigen::Vector3i> origins_;
};

}  // namespace scanknit
