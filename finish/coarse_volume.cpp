#include "finish/coarse_volume.h"

#include "finish/seen_leaves.h"

namespace scanknit {
namespace {

using openvdb::Coord;

/// The cube of the sample, by the index of its lowest sample divided by `step`.
Coord cube_of(const Coord& at, int step) {
  const auto along = [step](int index) { return index / step - (index % step < 0 ? 1 : 0); };
  return {along(at.x()), along(at.y()), along(at.z())};
}

template <typename Grid>
typename Grid::Ptr empty_like(const Grid* like, const openvdb::math::Transform& transform) {
  if (like == nullptr) return nullptr;
  auto grid = Grid::create(like->background());
  grid->setTransform(transform.copy());
  return grid;
}

/// Calls set(cube, colour) for the samples of a leaf that have a colour.
template <typename Grid, typename HasColour>
void add_colours(const Grid& from, const SeenLeaves::FieldLeaf& leaf, int step, const HasColour& is_colour, Grid& to) {
  const auto* colours = from.tree().probeConstLeaf(leaf.origin());
  if (colours == nullptr) return;
  auto set = to.getAccessor();
  for (openvdb::Index offset = 0; offset < SeenLeaves::FieldLeaf::SIZE; ++offset) {
    const auto& colour = colours->getValue(offset);
    if (is_colour(colour)) set.setValueOn(cube_of(leaf.offsetToGlobalCoord(offset), step), colour);
  }
}

}  // namespace

CoarseVolume::CoarseVolume(const FieldView& like, int step)
    : step_(step), is_signed_distance_(like.is_signed_distance) {
  if (like.region) region_ = openvdb::CoordBBox(cube_of(like.region->min(), step), cube_of(like.region->max(), step));
  const auto transform = like.field->transform().copy();
  transform->preTranslate(openvdb::Vec3d((step - 1) / 2.0));
  transform->preScale(step);
  field_ = empty_like(like.field, *transform);
  seen_ = openvdb::FloatGrid::create(0);
  colour_ = empty_like(like.colour, *transform);
  colour_codes_ = empty_like(like.colour_codes, *transform);
}

void CoarseVolume::add(const FieldView& part, double min_weight) {
  const SeenLeaves leaves(part, min_weight);
  auto sums = field_->getAccessor();
  auto counts = seen_->getAccessor();
  for (auto leaf = part.field->tree().cbeginLeaf(); leaf; ++leaf) {
    for (openvdb::Index offset = 0; offset < SeenLeaves::FieldLeaf::SIZE; ++offset) {
      if (!leaves.is_seen(*leaf, offset)) continue;
      const Coord cube = cube_of(leaf->offsetToGlobalCoord(offset), step_);
      const float count = counts.getValue(cube);
      sums.setValueOn(cube, leaf->getValue(offset) + (count > 0 ? sums.getValue(cube) : 0));
      counts.setValueOn(cube, count + 1);
    }
    if (colour_ && part.colour != nullptr) {
      add_colours(
          *part.colour, *leaf, step_, [](const openvdb::Vec3s& c) { return c.x() >= 0; }, *colour_);
    }
    if (colour_codes_ && part.colour_codes != nullptr) {
      add_colours(
          *part.colour_codes, *leaf, step_, [](ColourCode c) { return has_colour(c); }, *colour_codes_);
    }
  }
}

FieldView CoarseVolume::finish() {
  const float least = static_cast<float>(step_ * step_ * step_) / 4;
  const auto counts = seen_->getConstAccessor();
  for (auto leaf = field_->tree().beginLeaf(); leaf; ++leaf) {
    for (auto sum = leaf->beginValueOn(); sum; ++sum) {
      const float count = counts.getValue(sum.getCoord());
      sum.setValue(*sum / count);
      if (count < least) sum.setValueOff();
    }
  }
  seen_.reset();
  FieldView view;
  view.field = field_.get();
  view.colour = colour_.get();
  view.colour_codes = colour_codes_.get();
  view.region = region_;
  view.is_signed_distance = is_signed_distance_;
  return view;
}

}  // namespace scanknit
