// VdbBlocks: the leaves of an OpenVDB volume as blocks.
#pragma once

#include <openvdb/openvdb.h>

#include <vector>

#include "core/field_view.h"
#include "core/result.h"
#include "extract/blocks/block.h"

namespace scanknit {

/// Keeps the view's grids alive no longer than the caller does. Active tiles (constant regions that OpenVDB stores as
/// one value) are turned into leaves in a copy of the field.
class VdbBlocks final : public BlockSource {
 public:
  /// kConfig: the transform is not linear and invertible, or the grids' transforms differ. kBudget: the
  /// active tiles would unfold to more than 2^31 voxels. Throws what OpenVDB and the allocator throw.
  [[nodiscard]] static Result<VdbBlocks> open(const FieldView& view, double min_weight);

  /// The same volume with a shorter list: those of `origins` (sorted by is_before) at which it has a leaf now. Sees the
  /// samples of all leaves, as before. Takes time for the leaves asked about only.
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
  openvdb::FloatGrid::ConstPtr unfolded_;  // owns view_.field where it had active tiles
  float min_weight_;                       ///< the least weight above 0 that counts as observed
  Eigen::Affine3d T_world_index_;
  std::vector<Eigen::Vector3i> origins_;
};

}  // namespace scanknit
