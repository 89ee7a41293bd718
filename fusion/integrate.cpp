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
constexpr float kFreeSpaceShare = 0.05f;
constexpr float kTinyWeight = 1e-30f;  // far below any weight of a sighting, and no denormal

/// The three leaves of one block.
struct Block {
  FloatLeaf* tsdf = nullptr;
  FloatLeaf* weight = nullptr;
  ColourLeaf* colour = nullptr;
  bool is_new = false;
};

/// Eight voxels in a row along z, as the camera sees them.
struct VoxelRow {
  float x[kBlock], y[kBlock], z[kBlock];  ///< camera frame
  float distance_m[kBlock];               ///< clamped to the truncation
  float weight[kBlock];                   ///< 0: this frame says nothing of the voxel
  bool takes_colour[kBlock];
};

/// How far along z a point at `z_m` lies behind the plane it was sighted against; negative in front. On the point's ray
/// the plane is at z offset / (normal . ray), and normal . p = distance + offset. A plane that faces away is far.
float depth_behind(const Sighting& sighting, float z_m) {
  const float along_normal = sighting.distance_m + sighting.offset_m;  // negative for a plane that faces the camera
  return along_normal < 0 ? z_m * sighting.distance_m / along_normal : z_m;
}

/// How much a sighting counts at a voxel. A view measures to the surface that it sees; another part of the surface may
/// be nearer, and the larger the distance, the likelier that is: near edges and behind thin parts such views would
/// outvote the one that sees the nearest part. So the weight falls with the cube of 1 - |distance| / truncation, on
/// both sides alike so that noise has no preferred direction. Free space keeps kFreeSpaceShare: enough to carve. Behind
/// the surface nothing is known beyond the truncation along the ray. Why the cube: ScanKnit's rows of bench/compare.py,
/// with other powers here. On the turntable the first power doubles the error; in the noisy desk scene the fourth adds
/// a tenth.
float weight_at(const Sighting& sighting, float z_m) {
  const SurfacePixel& pixel = *sighting.pixel;
  const float nearness = std::max(0.0f, 1 - std::abs(sighting.distance_m) * pixel.per_truncation);
  const float share = nearness * nearness * nearness;
  if (sighting.distance_m >= 0) return pixel.weight * std::max(share, kFreeSpaceShare);
  return share > 0 && depth_behind(sighting, z_m) <= pixel.truncation_m ? pixel.weight * share : 0.0f;
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
    float* tsdf = block.tsdf->buffer().data();
    float* weight = block.weight->buffer().data();
    openvdb::Vec3s* colour = block.colour->buffer().data();
    FloatLeaf::NodeMaskType observed = block.tsdf->getValueMask();
    VoxelRow row;
    for (int n = 0; n < kBlock * kBlock; ++n) {  // a leaf's buffer runs along z first, then y, then x
      const auto i = static_cast<float>(n / kBlock);
      const auto j = static_cast<float>(n % kBlock);
      if (!sight_row(p_origin + i * step_[0] + j * step_[1], row)) continue;
      const int first = n * kBlock;
      update_row(row, tsdf + first, weight + first);
      for (int k = 0; k < kBlock; ++k) {
        if (row.weight[k] > 0) observed.setOn(static_cast<openvdb::Index>(first + k));
        if (row.takes_colour[k])
          update_colour({row.x[k], row.y[k], row.z[k]}, row.weight[k], weight[first + k], colour[first + k]);
      }
    }
    block.tsdf->setValueMask(observed);
    block.weight->setValueMask(observed);
    block.colour->setValueMask(observed);
  }

 private:
  /// Fills `row` from its first voxel; false when the frame says nothing of any of the eight.
  bool sight_row(const Eigen::Vector3f& p_first, VoxelRow& row) const {
    const PictureCamera camera = observation_.camera();
    float u[kBlock], v[kBlock];
    for (int k = 0; k < kBlock; ++k) {
      row.x[k] = p_first.x() + static_cast<float>(k) * step_[2].x();
      row.y[k] = p_first.y() + static_cast<float>(k) * step_[2].y();
      row.z[k] = p_first.z() + static_cast<float>(k) * step_[2].z();
      const float per_z = 1 / row.z[k];
      u[k] = camera.fx * row.x[k] * per_z + camera.cx;
      v[k] = camera.fy * row.y[k] * per_z + camera.cy;
    }
    bool any = false;
    for (int k = 0; k < kBlock; ++k) {
      row.weight[k] = 0;
      row.distance_m[k] = 0;
      row.takes_colour[k] = false;
      if (!(row.z[k] > 0) || !camera.sees(u[k], v[k])) continue;
      const Sighting sighting = observation_.sight(row.x[k], row.y[k], row.z[k], u[k], v[k]);
      if (sighting.pixel == nullptr) continue;
      const float truncation_m = sighting.pixel->truncation_m;
      row.weight[k] = weight_at(sighting, row.z[k]);
      row.distance_m[k] = std::min(sighting.distance_m, truncation_m);
      row.takes_colour[k] =
          observation_.has_colour() && row.weight[k] > 0 && std::abs(sighting.distance_m) < kInnerBand * truncation_m;
      any = any || row.weight[k] > 0;
    }
    return any;
  }

  /// The weighted running mean of eight voxels.
  void update_row(const VoxelRow& row, float* tsdf, float* weight) const {
    for (int k = 0; k < kBlock; ++k) {
      const float sum = weight[k] + row.weight[k];
      const float share = row.weight[k] / std::max(sum, kTinyWeight);  // 0 / tiny: an unseen voxel stays as it is
      tsdf[k] += (row.distance_m[k] - tsdf[k]) * share;
      weight[k] = std::min(sum, max_weight_);
    }
  }

  /// `weight` is the voxel's, this frame's `added` included.
  void update_colour(const Eigen::Vector3f& p_camera, float added, float weight, openvdb::Vec3s& colour) const {
    const Eigen::Vector4f seen = observation_.colour_at(p_camera);
    if (seen.w() == 0) return;
    const openvdb::Vec3s now(seen.x(), seen.y(), seen.z());
    colour = colour.x() < 0 ? now : colour + (now - colour) * (added / weight);
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
