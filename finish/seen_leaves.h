// SeenLeaves: the samples of a view that were observed with some weight.
#pragma once

#include <openvdb/openvdb.h>

#include <cmath>
#include <optional>

#include "core/field_view.h"

namespace scanknit {

/// Visits leaves, and tells for each voxel whether it was seen.
class SeenLeaves {
 public:
  using FieldLeaf = openvdb::FloatTree::LeafNodeType;

  SeenLeaves(const FieldView& view, double min_weight) : min_weight_(min_weight), fields_(view.field->tree()) {
    if (view.weight != nullptr) weights_.emplace(view.weight->tree());
    if (view.weight_codes != nullptr) codes_.emplace(view.weight_codes->tree());
  }

  [[nodiscard]] const FieldLeaf* leaf(const openvdb::Coord& origin) const { return fields_.probeConstLeaf(origin); }

  [[nodiscard]] bool is_seen(const FieldLeaf& leaf, openvdb::Index offset) const {
    if (!std::isfinite(leaf.getValue(offset))) return false;
    const openvdb::Coord at = leaf.offsetToGlobalCoord(offset);
    if (!weights_ && !codes_) return leaf.isValueOn(offset);
    const auto weight = static_cast<double>(weights_ ? weights_->getValue(at) : decode_weight(codes_->getValue(at)));
    return weight > 0 && weight >= min_weight_;
  }

 private:
  double min_weight_;
  openvdb::FloatGrid::ConstAccessor fields_;
  std::optional<openvdb::FloatGrid::ConstAccessor> weights_;
  std::optional<WeightCodeGrid::ConstAccessor> codes_;
};

}  // namespace scanknit
