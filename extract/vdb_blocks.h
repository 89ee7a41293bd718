// VdbBlocks: the leaves of an OpenVDB volume as blocks.
#pragma once

#include <openvdb/openvdb.h>

#include <vector>

#include "core/result.h"
#include "extract/block.h"
#include "extract/field_view.h"

namespace scanknit {

/// Keeps the view's grids alive no longer than the caller does. Active tiles (constant regions that OpenVDB stores as
/// one value) are turned into leaves in a copy of the field.
class VdbBlocks final : public BlockSource {
 public:
  /// kConfig: the transform is not uniform scale plus translation, or the grids' transforms differ. kBudget: the
  /// active tiles would unfold to more than 2^31 voxels. Throws what OpenVDB and the allocator throw.
  [[nodiscard]] static Result<VdbBlocks> open(const FieldView& view, double min_weight);

  [[nodiscard]] std::span<const Eigen::Vector3i> origins() const override { return origins_; }
  void load_values(std::size_t block, ValueBlock& values) const override;
  [[nodiscard]] bool has_colours() const override { return view_.colour != nullptr; }
  void load_colours(std::size_t block, ColourBlock& colours) const override;
  [[nodiscard]] double voxel_size_m() const override { return voxel_size_m_; }
  [[nodiscard]] Eigen::Vector3d translation_m() const override { return translation_m_; }

 private:
  VdbBlocks(const FieldView& view, double min_weight, double voxel_size_m, const Eigen::Vector3d& translation_m);

  FieldView view_;
  openvdb::FloatGrid::ConstPtr unfolded_;  // owns view_.field where it had active tiles
  double min_weight_;
  double voxel_size_m_;
  Eigen::Vector3d translation_m_;
  std::vector<Eigen::Vector3i> origins_;
};

}  // namespace scanknit
