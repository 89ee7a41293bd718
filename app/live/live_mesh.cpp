#include "app/live/live_mesh.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "core/voxel_codes.h"
#include "extract/smooth_normals.h"
#include "view/mesh_chunk.h"

namespace scanknit {
namespace {

constexpr int kLeafVoxels = kBlockCells;
constexpr int kChunkVoxels = 4 * kLeafVoxels;

Eigen::Vector3i chunk_of(const Eigen::Vector3i& leaf) {
  constexpr int kWithinChunk = kChunkVoxels - 1;  // two's complement: rounds towards minus infinity
  return {leaf.x() & ~kWithinChunk, leaf.y() & ~kWithinChunk, leaf.z() & ~kWithinChunk};
}

constexpr float kWellSeen = 10;  // weight of ten good views; a good view has weight 1

/// Samples colour, normal and coverage at the nearest voxel of the patch's leaf. Good enough to look at, and takes a
/// quarter of the time of exact normals and colours, which need all 26 neighbouring leaves.
class LeafSampler {
 public:
  LeafSampler(const TsdfVolume& volume, const VolumeBlock& block)
      : tsdf_(block.tsdf->buffer().data()),
        weights_(block.weight->buffer().data()),
        colours_(colours_of(*block.colour)),
        origin_(static_cast<float>(block.origin.x()), static_cast<float>(block.origin.y()),
                static_cast<float>(block.origin.z())),
        per_metre_(static_cast<float>(1 / volume.config().voxel_size_m)) {}

  [[nodiscard]] Eigen::Array3i voxel_at(const Eigen::Vector3f& p_world) const {
    return (p_world * per_metre_ - origin_).array().round().cast<int>().max(0).min(kLeafVoxels - 1);
  }

  /// 255 for ten good views or more.
  [[nodiscard]] std::uint8_t coverage(const Eigen::Array3i& voxel) const {
    const float share = std::min(1.0f, decode_weight(weights_[offset(voxel)]) / kWellSeen);
    return static_cast<std::uint8_t>(std::lrint(255 * std::sqrt(share)));
  }

  [[nodiscard]] Rgb8 colour(const Eigen::Array3i& voxel) const {
    const ColourCode code = colours_[offset(voxel)];
    return has_colour(code) ? decode_colour(code) : kNoColour;
  }

  /// A unit vector, or zero when a neighbouring voxel is unknown.
  [[nodiscard]] Eigen::Vector3f normal(const Eigen::Array3i& voxel) const {
    Eigen::Vector3f gradient;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      Eigen::Array3i before = voxel;
      Eigen::Array3i after = voxel;
      before[axis] = std::max(0, voxel[axis] - 1);
      after[axis] = std::min(kLeafVoxels - 1, voxel[axis] + 1);
      if (weights_[offset(before)] == 0 || weights_[offset(after)] == 0) return Eigen::Vector3f::Zero();
      gradient[axis] = (tsdf_[offset(after)] - tsdf_[offset(before)]) / static_cast<float>(after[axis] - before[axis]);
    }
    const float length = gradient.norm();
    return length > 0 ? Eigen::Vector3f(gradient / length) : Eigen::Vector3f::Zero();
  }

 private:
  static constexpr Rgb8 kNoColour{188, 188, 188};

  [[nodiscard]] static std::size_t offset(const Eigen::Array3i& voxel) {
    return static_cast<std::size_t>((voxel.x() * kLeafVoxels + voxel.y()) * kLeafVoxels + voxel.z());
  }

  const float* tsdf_;
  const WeightCode* weights_;
  const ColourCode* colours_;
  Eigen::Vector3f origin_;
  float per_metre_;
};

/// A patch with normals, colours and coverage.
struct ColouredPatch {
  Mesh mesh;
  std::vector<std::uint8_t> coverage;
};

ColouredPatch coloured(const TsdfVolume& volume, const MeshPatch& patch) {
  ColouredPatch result{patch.mesh, {}};
  const auto block = volume.index().find({patch.origin.x(), patch.origin.y(), patch.origin.z()});
  const LeafSampler leaf(volume, volume.index().blocks()[block]);
  for (const Eigen::Vector3f& position : patch.mesh.positions_m) {
    const Eigen::Array3i voxel = leaf.voxel_at(position);
    result.mesh.normals.push_back(leaf.normal(voxel));
    result.mesh.colours.push_back(leaf.colour(voxel));
    result.coverage.push_back(leaf.coverage(voxel));
  }
  fill_missing_normals(result.mesh);
  return result;
}

}  // namespace

LiveMesh::LiveMesh(const TsdfVolume& volume, IncrementalMesher mesher, std::uint32_t last_revision)
    : mesher_(std::move(mesher)), last_revision_(last_revision), voxel_size_m_(volume.config().voxel_size_m) {
  for (const VolumeBlock& block : volume.index().blocks()) note(volume, block.origin);
}

void LiveMesh::note(const TsdfVolume& volume, const openvdb::Coord& leaf) {
  states_.resize(volume.index().blocks().size());
  const BlockIndex::Number number = volume.index().find(leaf);
  BlockState& state = states_[number];
  if (volume.index().blocks()[number].has_matter) {
    if (state.waiting == Waiting::kMatter) return;
    state.waiting = Waiting::kMatter;
    if (state.was_meshed) {
      queue_changed(number);
    } else {
      new_.push_back(number);
    }
  } else if (state.waiting == Waiting::kNot) {
    state.waiting = Waiting::kFree;
    free_.push_back(number);
  }
}

void LiveMesh::queue_changed(BlockIndex::Number number) {
  if (!std::exchange(states_[number].is_in_changed, true)) changed_.push_back(number);
}

Result<LiveMesh> LiveMesh::create(const TsdfVolume& volume, const ExtractConfig& config, std::uint32_t last_revision) {
  ExtractConfig live = config;
  if (is_tetrahedral(live.decider)) live.decider = Decider::kTrilinear;  // the incremental mesher has no tetrahedra
  live.normals = false;
  auto mesher = IncrementalMesher::create(volume.field_view().without_colours(), live);
  if (!mesher) return mesher.error();
  return LiveMesh(volume, *std::move(mesher), last_revision);
}

/// Takes a leaf, if it still waits, and with it the waiting leaves of the same kind in its chunk, so that the chunk is
/// written once for all of them.
void LiveMesh::take_chunk(const TsdfVolume& volume, BlockIndex::Number first, std::size_t most_leaves,
                          std::vector<BlockIndex::Number>& some) {
  const bool was_meshed = states_[first].was_meshed;
  const auto take = [&](BlockIndex::Number number) {
    if (states_[number].waiting != Waiting::kMatter || states_[number].was_meshed != was_meshed) return;
    states_[number].waiting = Waiting::kNot;
    some.push_back(number);
  };
  if (states_[first].waiting != Waiting::kMatter) return;  // taken before, with another leaf of its chunk
  take(first);
  const openvdb::Coord& origin = volume.index().blocks()[first].origin;
  const Eigen::Vector3i chunk = chunk_of({origin.x(), origin.y(), origin.z()});
  for (int x = 0; x < kChunkVoxels; x += kLeafVoxels) {
    for (int y = 0; y < kChunkVoxels; y += kLeafVoxels) {
      for (int z = 0; z < kChunkVoxels && some.size() < most_leaves; z += kLeafVoxels) {
        const Eigen::Vector3i leaf = chunk + Eigen::Vector3i(x, y, z);
        const BlockIndex::Number number = volume.index().find({leaf.x(), leaf.y(), leaf.z()});
        if (number < states_.size()) take(number);
      }
    }
  }
}

std::vector<BlockIndex::Number> LiveMesh::take_some(const TsdfVolume& volume, std::size_t most_leaves) {
  std::vector<BlockIndex::Number> some;
  while (some.size() < most_leaves && !new_.empty()) {
    const BlockIndex::Number number = new_.back();
    new_.pop_back();
    take_chunk(volume, number, most_leaves, some);
  }
  while (some.size() < most_leaves && !changed_.empty()) {
    const BlockIndex::Number number = changed_.front();
    changed_.pop_front();
    states_[number].is_in_changed = false;
    take_chunk(volume, number, most_leaves, some);
  }
  while (some.size() < most_leaves && !free_.empty()) {
    BlockState& state = states_[free_.front()];
    if (state.waiting == Waiting::kFree) {
      some.push_back(free_.front());
      state.waiting = Waiting::kNot;
    }
    free_.pop_front();
  }
  return some;
}

Result<void> LiveMesh::update(TsdfVolume& volume, std::size_t most_leaves, const Publish& publish) {
  for (const openvdb::Coord& origin : volume.take_changed_blocks()) note(volume, origin);
  const std::vector<BlockIndex::Number> some = take_some(volume, most_leaves);
  std::vector<Eigen::Vector3i> leaves;
  for (const BlockIndex::Number number : some) {
    const openvdb::Coord& origin = volume.index().blocks()[number].origin;
    leaves.emplace_back(origin.x(), origin.y(), origin.z());
  }
  const auto different = mesher_.update(leaves);
  if (!different) {
    for (const BlockIndex::Number number : some) {
      states_[number].waiting = Waiting::kMatter;
      queue_changed(number);
    }
    return different.error();
  }
  for (const BlockIndex::Number number : some) states_[number].was_meshed = true;

  std::set<Eigen::Vector3i, BlockOrder> chunks;
  for (const Eigen::Vector3i& leaf : *different) chunks.insert(chunk_of(leaf));
  for (const Eigen::Vector3i& leaf : leaves) {  // the colours may have changed although the triangles have not
    if (mesher_.patches().contains(leaf)) chunks.insert(chunk_of(leaf));
  }
  for (const Eigen::Vector3i& at : chunks) {
    const auto [chunk, is_new] = chunks_.try_emplace(at);
    if (is_new) chunk->second.number = static_cast<std::uint32_t>(chunks_.size());
    triangles_ -= chunk->second.triangles;
    publish(chunk->second.number, message_of(volume, at, chunk->second));
    triangles_ += chunk->second.triangles;
  }
  return {};
}

bool LiveMesh::has_triangle_in(const Eigen::AlignedBox3d& box) const {
  const Eigen::AlignedBox3f box_f = box.cast<float>();
  for (const auto& [origin, patch] : mesher_.patches()) {
    const Eigen::Vector3d first = voxel_size_m_ * origin.cast<double>();
    const Eigen::AlignedBox3d cells(first, first + Eigen::Vector3d::Constant(voxel_size_m_ * kLeafVoxels));
    if (!box.intersects(cells)) continue;
    const Mesh& mesh = patch.mesh;
    const auto is_inside = [&](std::uint32_t vertex) { return box_f.contains(mesh.positions_m[vertex]); };
    const auto lies_inside = [&](const auto& triangle) {
      return std::all_of(triangle.begin(), triangle.end(), is_inside);
    };
    if (std::any_of(mesh.triangles.begin(), mesh.triangles.end(), lies_inside)) return true;
  }
  return false;
}

std::string LiveMesh::message_of(const TsdfVolume& volume, const Eigen::Vector3i& at, Chunk& chunk) const {
  std::vector<ColouredPatch> patches;
  for (int x = 0; x < kChunkVoxels; x += kLeafVoxels) {
    for (int y = 0; y < kChunkVoxels; y += kLeafVoxels) {
      for (int z = 0; z < kChunkVoxels; z += kLeafVoxels) {
        const auto patch = mesher_.patches().find(at + Eigen::Vector3i(x, y, z));
        if (patch != mesher_.patches().end()) patches.push_back(coloured(volume, patch->second));
      }
    }
  }
  std::vector<ChunkPart> parts;
  chunk.triangles = 0;
  for (ColouredPatch& patch : patches) {
    chunk.triangles += patch.mesh.triangles.size();
    parts.push_back({&patch.mesh, std::move(patch.coverage)});
  }
  const std::uint32_t revision = this->revision();
  if (parts.empty()) return chunk_gone_message(chunk.number, revision);
  const float step_m = step_for(static_cast<float>((kChunkVoxels + 2) * volume.config().voxel_size_m));
  return chunk_message(chunk.number, revision, parts, step_m);
}

}  // namespace scanknit
