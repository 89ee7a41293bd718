#include "finish/close_volume.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "finish/seen_leaves.h"
#include "finish/smallest_surface.h"

namespace scanknit {
namespace {

using openvdb::Coord;
using FieldLeaf = SeenLeaves::FieldLeaf;

constexpr int kSide = 8;                                   // voxels along the side of a leaf
constexpr std::size_t kBytesPerVoxel = sizeof(float) + 2;  // of a Box

struct Box {
  VoxelBox voxels;
  std::vector<VoxelLabel> labels;
  std::vector<float> distance_m;  ///< distance from the isovalue
  std::vector<std::uint8_t> is_seen;
};

int leaf_floor(double index) {
  return static_cast<int>(std::floor(index / kSide)) * kSide;
}

/// The box of whole leaves round the surface, with a rim outside of the band as room for the fill.
VoxelBox box_round(const FieldView& view, const CloseRequest& request) {
  Eigen::AlignedBox3d index_box;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d p = request.surface.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner));
    const openvdb::Vec3d index = view.field->transform().worldToIndex({p.x(), p.y(), p.z()});
    index_box.extend(Eigen::Vector3d(index.x(), index.y(), index.z()));
  }
  const double rim = std::ceil(request.band_voxels) + 3;
  VoxelBox box;
  for (int axis = 0; axis < 3; ++axis) {
    box.first[axis] = leaf_floor(index_box.min()[axis] - rim);
    box.dims[axis] = leaf_floor(index_box.max()[axis] + rim) + kSide - box.first[axis];
  }
  return box;
}

/// Reads the samples of a leaf that were seen, and applies the cut.
void read_leaf(const FieldView& view, const CloseRequest& request, const Eigen::Vector3i& at, Box& box) {
  const SeenLeaves leaves(view, request.min_weight);
  const VoxelBox& voxels = box.voxels;
  const Coord origin(voxels.first.x() + at.x(), voxels.first.y() + at.y(), voxels.first.z() + at.z());
  const FieldLeaf* leaf = leaves.leaf(origin);
  const auto& transform = view.field->transform();
  for (openvdb::Index offset = 0; offset < FieldLeaf::SIZE; ++offset) {
    const Coord local = FieldLeaf::offsetToLocalCoord(offset);
    const Eigen::Vector3i place = at + Eigen::Vector3i(local.x(), local.y(), local.z());
    const std::size_t i = voxels.at(place.x(), place.y(), place.z());
    const bool is_seen = leaf != nullptr && leaves.is_seen(*leaf, offset);
    float distance = is_seen ? leaf->getValue(offset) - static_cast<float>(request.isovalue_m) : 0.0f;
    bool is_cut = false;
    if (request.cut_m) {
      const openvdb::Vec3d p = transform.indexToWorld(origin + local);
      const auto cut = static_cast<float>(request.cut_m({p.x(), p.y(), p.z()}));
      is_cut = is_seen ? cut > distance : cut >= 0;
      if (is_cut) distance = cut;
    }
    const bool is_rim = (place.array() == 0).any() || (place.array() == voxels.dims.array() - 1).any();
    const bool is_beyond = request.is_outside_free && is_rim && !(is_seen && distance >= 0);
    if (is_beyond) distance = static_cast<float>(transform.voxelSize().x());
    box.is_seen[i] = is_seen && !is_cut && !is_beyond ? 1 : 0;
    box.distance_m[i] = distance;
    const bool is_known = is_seen || is_cut || is_beyond;
    box.labels[i] = !is_known ? VoxelLabel::kUnknown : distance < 0 ? VoxelLabel::kMatter : VoxelLabel::kFree;
  }
}

std::vector<Eigen::Vector3i> leaf_places(const VoxelBox& box) {
  std::vector<Eigen::Vector3i> places;
  for (int x = 0; x < box.dims.x(); x += kSide) {
    for (int y = 0; y < box.dims.y(); y += kSide) {
      for (int z = 0; z < box.dims.z(); z += kSide) places.emplace_back(x, y, z);
    }
  }
  return places;
}

/// Whether a cell that reaches into the leaf has both signs.
bool has_surface(const Box& box, const Eigen::Vector3i& at) {
  const VoxelBox& voxels = box.voxels;
  bool has_matter = false;
  bool has_free = false;
  const Eigen::Vector3i low = (at.array() - 1).max(0);
  const Eigen::Vector3i high = (at.array() + kSide).min(voxels.dims.array() - 1);
  for (int x = low.x(); x <= high.x(); ++x) {
    for (int y = low.y(); y <= high.y(); ++y) {
      for (int z = low.z(); z <= high.z(); ++z) {
        const bool is_matter = box.distance_m[voxels.at(x, y, z)] < 0;
        has_matter |= is_matter;
        has_free |= !is_matter;
      }
    }
  }
  return has_matter && has_free;
}

/// Gives unknown samples the filled distances; keeps the cut.
void take_filled(const FieldView& view, const CloseRequest& request, const std::vector<float>& distance_vox, Box& box) {
  const auto& transform = view.field->transform();
  const auto voxel_m = static_cast<float>(transform.voxelSize().x());
  tbb::parallel_for(std::size_t{0}, box.labels.size(), [&](std::size_t i) {
    if (box.labels[i] != VoxelLabel::kUnknown) return;
    box.distance_m[i] = distance_vox[i] * voxel_m;
    if (!request.cut_m) return;
    const Eigen::Vector3i at = box.voxels.first + box.voxels.place(i);
    const openvdb::Vec3d p = transform.indexToWorld(Coord(at.x(), at.y(), at.z()));
    box.distance_m[i] = std::max(box.distance_m[i], static_cast<float>(request.cut_m({p.x(), p.y(), p.z()})));
  });
}

openvdb::FloatGrid::Ptr to_grid(const FieldView& view, const CloseRequest& request, const Box& box) {
  auto grid = openvdb::FloatGrid::create(view.field->background());
  grid->setTransform(view.field->transform().copy());
  for (const Eigen::Vector3i& at : leaf_places(box.voxels)) {
    if (!has_surface(box, at)) continue;
    const Coord origin(box.voxels.first.x() + at.x(), box.voxels.first.y() + at.y(), box.voxels.first.z() + at.z());
    FieldLeaf* leaf = grid->tree().touchLeaf(origin);
    for (openvdb::Index offset = 0; offset < FieldLeaf::SIZE; ++offset) {
      const Coord local = FieldLeaf::offsetToLocalCoord(offset);
      const std::size_t i = box.voxels.at(at.x() + local.x(), at.y() + local.y(), at.z() + local.z());
      leaf->setValueOn(offset, box.distance_m[i] + static_cast<float>(request.isovalue_m));
    }
  }
  return grid;
}

Error too_large(const VoxelBox& box, double bytes, std::size_t max_bytes) {
  constexpr double kMebibyte = 1024.0 * 1024.0;
  return {ErrorCode::kBudget,
          fmt::format("the box round the surface has {} x {} x {} voxels, which takes {:.0f} MiB to close; {:.0f} are "
                      "left of fusion.memory_budget: raise it, crop the box (finish.crop), or take larger voxels",
                      box.dims.x(), box.dims.y(), box.dims.z(), std::ceil(bytes / kMebibyte),
                      static_cast<double>(max_bytes) / kMebibyte),
          "finish.watertight"};
}

/// Fills the box's unknown samples. kBudget: it does not fit.
Result<void> fill(const FieldView& view, const CloseRequest& request, Box& box) {
  const auto voxel_m = static_cast<float>(view.field->voxelSize().x());
  const std::size_t box_bytes = box.voxels.voxels() * kBytesPerVoxel;
  const FilledField filled = fill_by_smallest_surface(box.voxels, box.labels, {box.distance_m, voxel_m},
                                                      request.band_voxels, request.memory_bytes - box_bytes);
  if (filled.distance_vox.empty()) {
    return too_large(box.voxels, static_cast<double>(box_bytes + filled.bytes), request.memory_bytes);
  }
  take_filled(view, request, filled.distance_vox, box);
  return {};
}

}  // namespace

bool ClosedVolume::is_seen_cell(const Eigen::Vector3i& low) const {
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3i at = low - box.first + Eigen::Vector3i(corner & 1, corner >> 1 & 1, corner >> 2);
    if (!box.contains(at.x(), at.y(), at.z()) || is_seen[box.at(at.x(), at.y(), at.z())] == 0) return false;
  }
  return true;
}

Eigen::Vector3d ClosedVolume::index_of(const Eigen::Vector3d& p_world) const {
  const openvdb::Vec3d index = field->transform().worldToIndex({p_world.x(), p_world.y(), p_world.z()});
  return {index.x(), index.y(), index.z()};
}

Result<ClosedVolume> close_volume(const FieldView& view, const CloseRequest& request) {
  if (!view.field->transform().isLinear() || !view.field->hasUniformVoxels()) {
    return Error{ErrorCode::kConfig, "voxels that are no cubes cannot be closed", "finish.watertight"};
  }
  Box box;
  box.voxels = box_round(view, request);
  const double voxels = box.voxels.dims.cast<double>().prod();
  const double least_bytes = static_cast<double>(kBytesPerVoxel + kLeastFillBytesPerVoxel) * voxels;
  const bool fits_index = voxels < std::numeric_limits<std::uint32_t>::max();
  if (least_bytes > static_cast<double>(request.memory_bytes) || !fits_index) {
    return too_large(box.voxels, least_bytes, request.memory_bytes);
  }
  const std::size_t n = box.voxels.voxels();
  box.labels.resize(n);
  box.distance_m.resize(n);
  box.is_seen.resize(n);
  const auto places = leaf_places(box.voxels);
  tbb::parallel_for(std::size_t{0}, places.size(), [&](std::size_t i) { read_leaf(view, request, places[i], box); });
  if (auto filled = fill(view, request, box); !filled) return filled.error();
  ClosedVolume closed;
  closed.field = to_grid(view, request, box);
  closed.box = box.voxels;
  closed.is_seen = std::move(box.is_seen);
  return closed;
}

openvdb::FloatGrid::Ptr cut_open(const FieldView& view, double min_weight,
                                 const std::function<double(const Eigen::Vector3d& p_world)>& cut_m) {
  auto grid = openvdb::FloatGrid::create(view.field->background());
  grid->setTransform(view.field->transform().copy());
  const SeenLeaves leaves(view, min_weight);
  for (auto leaf = view.field->tree().cbeginLeaf(); leaf; ++leaf) {
    FieldLeaf* copy = grid->tree().touchLeaf(leaf->origin());
    for (openvdb::Index offset = 0; offset < FieldLeaf::SIZE; ++offset) {
      if (!leaves.is_seen(*leaf, offset)) continue;
      const openvdb::Vec3d p = view.field->transform().indexToWorld(leaf->offsetToGlobalCoord(offset));
      if (!(cut_m({p.x(), p.y(), p.z()}) > 0)) copy->setValueOn(offset, leaf->getValue(offset));
    }
  }
  return grid;
}

}  // namespace scanknit
