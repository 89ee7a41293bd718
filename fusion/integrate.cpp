#include "fusion/integrate.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <utility>

#include "fusion/band_blocks.h"
#include "fusion/observation.h"

namespace scanknit {
namespace {

using openvdb::Coord;
using FloatLeaf = openvdb::FloatTree::LeafNodeType;
using ColourLeaf = openvdb::Vec3STree::LeafNodeType;

constexpr int kBlock = 8;

/// The three leaves of one block.
struct Block {
  FloatLeaf* tsdf = nullptr;
  FloatLeaf* weight = nullptr;
  ColourLeaf* colour = nullptr;
  bool is_new = false;
};

/// Their voxels, and which of them are observed.
struct Voxels {
  explicit Voxels(const Block& block)
      : tsdf(block.tsdf->buffer().data()),
        weight(block.weight->buffer().data()),
        colour(block.colour->buffer().data()),
        observed(block.tsdf->getValueMask()) {}
  float* tsdf;
  float* weight;
  openvdb::Vec3s* colour;
  FloatLeaf::NodeMaskType observed;
};

/// Behind the surface the evidence fades: it is least certain there, and must not push through thin walls
/// (the linear weight of Bylow et al. 2013, "Real-Time Camera Tracking and 3D Reconstruction Using Signed Distance
/// Functions", section IV-B, with epsilon = 0).
float weight_at(const Sighting& sighting) {
  if (sighting.distance_m >= 0) return sighting.weight;
  return sighting.weight * (1 + sighting.distance_m / sighting.truncation_m);
}

/// Applies one frame to blocks. Holds what is the same for all voxels.
class BlockUpdate {
 public:
  BlockUpdate(const Observation& observation, const Pose& T_world_camera, const TsdfVolume& volume)
      : observation_(observation),
        T_camera_world_(T_world_camera.inverse()),
        voxel_size_m_(volume.config().voxel_size_m),
        max_weight_(static_cast<float>(volume.config().max_weight)) {
    for (int axis = 0; axis < 3; ++axis) {
      step_[axis] = (T_camera_world_.linear().col(axis) * voxel_size_m_).cast<float>();
    }
  }

  void apply(const Block& block) const {
    const Coord origin = block.tsdf->origin();
    const Eigen::Vector3f p_origin =
        (T_camera_world_ * (Eigen::Vector3d(origin.x(), origin.y(), origin.z()) * voxel_size_m_)).cast<float>();
    Voxels voxels(block);
    openvdb::Index voxel = 0;  // a leaf's buffer runs along z first, then y, then x
    for (int i = 0; i < kBlock; ++i) {
      for (int j = 0; j < kBlock; ++j) {
        const Eigen::Vector3f p_row = p_origin + static_cast<float>(i) * step_[0] + static_cast<float>(j) * step_[1];
        for (int k = 0; k < kBlock; ++k, ++voxel) {
          update(voxels, voxel, p_row + static_cast<float>(k) * step_[2]);
        }
      }
    }
    block.tsdf->setValueMask(voxels.observed);
    block.weight->setValueMask(voxels.observed);
    block.colour->setValueMask(voxels.observed);
  }

 private:
  void update(Voxels& voxels, openvdb::Index at, const Eigen::Vector3f& p_camera) const {
    const auto sighting = observation_.sight(p_camera);
    if (!sighting) return;
    const float weight = weight_at(*sighting);
    if (!(weight > 0)) return;  // hidden behind the band

    const float old_weight = voxels.weight[at];
    const float new_weight = old_weight + weight;
    const float share = weight / new_weight;  // new_weight >= weight > 0; 1 for a voxel that was unknown
    const float distance_m = std::min(sighting->distance_m, sighting->truncation_m);
    voxels.tsdf[at] += (distance_m - voxels.tsdf[at]) * share;
    voxels.weight[at] = std::min(new_weight, max_weight_);
    voxels.observed.setOn(at);
    if (observation_.has_colour() && sighting->distance_m < sighting->truncation_m) {
      update_colour(voxels.colour[at], p_camera, share);
    }
  }

  void update_colour(openvdb::Vec3s& colour, const Eigen::Vector3f& p_camera, float share) const {
    const auto seen = observation_.colour_at(p_camera);
    if (!seen) return;
    const openvdb::Vec3s now(seen->x(), seen->y(), seen->z());
    colour = colour.x() < 0 ? now : colour + (now - colour) * share;
  }

  const Observation& observation_;
  Pose T_camera_world_;
  double voxel_size_m_;
  float max_weight_;
  Eigen::Vector3f step_[3];
};

/// The blocks of the band, made where they are missing and the budget allows.
std::vector<Block> open_band_blocks(const std::vector<Coord>& origins, TsdfVolume& volume, IntegrateStats& stats) {
  openvdb::FloatGrid::Accessor tsdf = volume.tsdf().getAccessor();
  openvdb::FloatGrid::Accessor weight = volume.weight().getAccessor();
  openvdb::Vec3SGrid::Accessor colour = volume.colour().getAccessor();
  std::size_t room = volume.max_blocks() - std::min(volume.max_blocks(), volume.blocks());
  std::vector<Block> blocks;
  blocks.reserve(origins.size());
  for (const Coord& origin : origins) {
    const bool is_new = tsdf.probeLeaf(origin) == nullptr;
    if (is_new && room == 0) {
      stats.is_budget_reached = true;
      continue;
    }
    if (is_new) --room;
    blocks.push_back({tsdf.touchLeaf(origin), weight.touchLeaf(origin), colour.touchLeaf(origin), is_new});
  }
  return blocks;
}

/// Known blocks outside the band that hold space in front of it.
std::vector<Block> find_blocks_in_front(const Observation& observation, const Pose& T_world_camera,
                                        const std::vector<Coord>& band, TsdfVolume& volume) {
  std::vector<FloatLeaf*> tsdf_leaves;
  std::vector<FloatLeaf*> weight_leaves;
  std::vector<ColourLeaf*> colour_leaves;  // one topology: the same order in all three trees
  volume.tsdf().tree().getNodes(tsdf_leaves);
  volume.weight().tree().getNodes(weight_leaves);
  volume.colour().tree().getNodes(colour_leaves);
  SCANKNIT_CHECK(tsdf_leaves.size() == weight_leaves.size() && tsdf_leaves.size() == colour_leaves.size());

  const BoxProjector projector(observation.intrinsics(), T_world_camera, volume.config().voxel_size_m);
  std::vector<char> is_in_front(tsdf_leaves.size(), 0);
  tbb::parallel_for(std::size_t{0}, tsdf_leaves.size(), [&](std::size_t i) {
    const Coord origin = tsdf_leaves[i]->origin();
    const BoxView view = projector.view(origin, origin.offsetBy(kBlock - 1));
    // In front of a band: some pixel's band begins behind the block's front.
    const DepthRange beyond{view.z.near_m, DepthRange{}.near_m};
    if (!view.is_in_front || !observation.bands().may_meet(view.pixels, beyond)) return;
    is_in_front[i] = std::binary_search(band.begin(), band.end(), origin) ? 0 : 1;
  });
  std::vector<Block> blocks;
  for (std::size_t i = 0; i < tsdf_leaves.size(); ++i) {
    if (is_in_front[i] != 0) blocks.push_back({tsdf_leaves[i], weight_leaves[i], colour_leaves[i], false});
  }
  return blocks;
}

/// Takes back the new blocks in which nothing was observed.
std::size_t remove_unseen(const std::vector<Block>& blocks, TsdfVolume& volume) {
  std::size_t removed = 0;
  for (const Block& block : blocks) {
    if (!block.is_new || !block.tsdf->isEmpty()) continue;
    const Coord origin = block.tsdf->origin();
    const auto drop = [&origin](auto& tree) {
      using Leaf = typename std::decay_t<decltype(tree)>::LeafNodeType;
      delete tree.template stealNode<Leaf>(origin, tree.background(), false);
    };
    drop(volume.tsdf().tree());
    drop(volume.weight().tree());
    drop(volume.colour().tree());
    ++removed;
  }
  return removed;
}

std::uint64_t key_of(const Coord& origin) {
  const auto part = [](int v) { return static_cast<std::uint64_t>(static_cast<std::uint32_t>(v >> 3) & 0x1FFFFFu); };
  return part(origin.x()) << 42 | part(origin.y()) << 21 | part(origin.z());
}

}  // namespace

Result<IntegrateStats> integrate(const Frame& frame, const Pose& T_world_camera, TsdfVolume& volume) {
  if (!is_rigid(T_world_camera)) return Error{ErrorCode::kInput, "the pose is not a rigid motion"};
  try {
    const Observation observation(frame, volume.config());
    if (!is_indexable(observation, T_world_camera, volume.config().voxel_size_m)) {
      return Error{ErrorCode::kInput, "the pose is too far from the world's origin for this voxel size"};
    }
    IntegrateStats stats;
    const auto origins = find_band_blocks(observation, T_world_camera, volume.config().voxel_size_m);
    std::vector<Block> blocks = open_band_blocks(origins, volume, stats);
    if (volume.config().carve_free_space) {
      const auto in_front = find_blocks_in_front(observation, T_world_camera, origins, volume);
      blocks.insert(blocks.end(), in_front.begin(), in_front.end());
    }
    const BlockUpdate update(observation, T_world_camera, volume);
    tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t i) { update.apply(blocks[i]); });

    stats.blocks_touched = blocks.size();
    stats.blocks_added = static_cast<std::size_t>(
        std::count_if(blocks.begin(), blocks.end(), [](const Block& block) { return block.is_new; }));
    stats.blocks_added -= remove_unseen(blocks, volume);
    volume.is_budget_reached = volume.is_budget_reached || stats.is_budget_reached;
    return stats;
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kBudget, "out of memory while integrating a frame; a larger fusion.voxel_size needs less"};
  } catch (const openvdb::Exception& e) {
    return Error{ErrorCode::kInternal, std::string("OpenVDB: ") + e.what()};
  }
}

BlockCounter::BlockCounter(const FusionConfig& config, std::size_t max_blocks)
    : config_(config), max_blocks_(max_blocks) {}

void BlockCounter::add(const Frame& frame, const Pose& T_world_camera) {
  if (is_full() || !is_rigid(T_world_camera)) return;
  const Observation observation(frame, config_);
  if (!is_indexable(observation, T_world_camera, config_.voxel_size_m)) return;
  for (const Coord& origin : find_band_blocks(observation, T_world_camera, config_.voxel_size_m)) {
    if (is_full()) return;
    keys_.insert(key_of(origin));
  }
}

std::size_t BlockCounter::blocks() const {
  return keys_.size();
}

}  // namespace scanknit
