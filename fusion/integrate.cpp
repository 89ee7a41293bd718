#include "fusion/integrate.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <new>
#include <utility>

#include "fusion/band_blocks.h"
#include "fusion/observation.h"
#include "fusion/update_block.h"

namespace scanknit {
namespace {

using openvdb::Coord;
using FloatLeaf = openvdb::FloatTree::LeafNodeType;
using ColourLeaf = openvdb::Vec3STree::LeafNodeType;

/// The three leaves of one block.
struct Block {
  FloatLeaf* tsdf = nullptr;
  FloatLeaf* weight = nullptr;
  ColourLeaf* colour = nullptr;
  bool is_new = false;
};

/// Applies one frame to blocks. Holds what is the same for all voxels.
class BlockUpdate {
 public:
  BlockUpdate(const Observation& observation, const Pose& T_world_camera, const TsdfVolume& volume)
      : observation_(observation),
        view_(observation.surface(), observation.intrinsics(), volume.config()),
        T_camera_world_(T_world_camera.inverse()),
        voxel_size_m_(volume.config().voxel_size_m) {
    for (int axis = 0; axis < 3; ++axis) {
      step_[axis] = (T_camera_world_.linear().col(axis) * voxel_size_m_).cast<float>();
    }
  }

  void apply(const Block& block) const {
    const Coord origin = block.tsdf->origin();
    const Eigen::Vector3f first =
        (T_camera_world_ * (Eigen::Vector3d(origin.x(), origin.y(), origin.z()) * voxel_size_m_)).cast<float>();
    const auto array = [](const Eigen::Vector3f& v) { return std::array{v.x(), v.y(), v.z()}; };
    const BlockPlace place{array(first), {array(step_[0]), array(step_[1]), array(step_[2])}};
    float* const weight = block.weight->buffer().data();
    BlockChange change;
    update_block(view_, place, {block.tsdf->buffer().data(), weight}, change);
    if (observation_.has_colour()) update_colours(first, change, weight, block.colour->buffer().data());

    FloatLeaf::NodeMaskType observed = block.tsdf->getValueMask();
    for (std::size_t x = 0; x < change.observed.size(); ++x)
      observed.getWord<std::uint64_t>(static_cast<openvdb::Index>(x)) |= change.observed[x];
    block.tsdf->setValueMask(observed);
    block.weight->setValueMask(observed);
    block.colour->setValueMask(observed);
  }

 private:
  /// `weight`: the voxels', this frame's included.
  void update_colours(const Eigen::Vector3f& first, const BlockChange& change, const float* weight,
                      openvdb::Vec3s* colours) const {
    for (int x = 0; x < kBlockSide; ++x) {
      for (std::uint64_t bits = change.takes_colour[static_cast<std::size_t>(x)]; bits != 0; bits &= bits - 1) {
        const int bit = std::countr_zero(bits);
        const auto voxel = static_cast<std::size_t>(kBlockSide * kBlockSide * x + bit);
        const Eigen::Vector3f p_camera = first + static_cast<float>(x) * step_[0] +
                                         static_cast<float>(bit / kBlockSide) * step_[1] +
                                         static_cast<float>(bit % kBlockSide) * step_[2];
        const Eigen::Vector4f seen = observation_.colour_at(p_camera);
        if (seen.w() == 0) continue;
        openvdb::Vec3s& colour = colours[voxel];
        const openvdb::Vec3s now(seen.x(), seen.y(), seen.z());
        colour = colour.x() < 0 ? now : colour + (now - colour) * (change.added[voxel] / weight[voxel]);
      }
    }
  }

  const Observation& observation_;
  FrameView view_;
  Pose T_camera_world_;
  double voxel_size_m_;
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
    const BoxView view = projector.view(origin, origin.offsetBy(kBlockSide - 1));
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
