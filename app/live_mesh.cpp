#include "app/live_mesh.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "core/voxel_codes.h"
#include "view/mesh_chunk.h"

namespace scanknit {
namespace {

constexpr int kLeafVoxels = 8;
constexpr int kChunkVoxels = 4 * kLeafVoxels;

Eigen::Vector3i chunk_of(const Eigen::Vector3i& leaf) {
  constexpr int kWithinChunk = kChunkVoxels - 1;  // two's complement: rounds towards minus infinity
  return {leaf.x() & ~kWithinChunk, leaf.y() & ~kWithinChunk, leaf.z() & ~kWithinChunk};
}

FieldView view_of(const TsdfVolume& volume) {
  FieldView view;
  view.field = &volume.tsdf();
  view.weight_codes = &volume.weight();
  view.colour_codes = &volume.colour();
  return view;
}

/// How well each vertex of a patch was seen, by the voxel next to it: 255 from ten good views on.
std::vector<std::uint8_t> coverage_of(const TsdfVolume& volume, const MeshPatch& patch) {
  constexpr float kWellSeen = 10;  // a good view weighs 1
  std::vector<std::uint8_t> coverage(patch.mesh.positions_m.size());
  const auto block = volume.index().find({patch.origin.x(), patch.origin.y(), patch.origin.z()});
  if (block == BlockIndex::kNone) return coverage;
  const WeightCode* const weights = volume.index().blocks()[block].weight->buffer().data();
  const auto per_metre = static_cast<float>(1 / volume.config().voxel_size_m);
  for (std::size_t i = 0; i < coverage.size(); ++i) {
    const Eigen::Vector3f at = patch.mesh.positions_m[i] * per_metre - patch.origin.cast<float>();
    const Eigen::Array3i voxel = at.array().round().cast<int>().max(0).min(kLeafVoxels - 1);
    const float weight = decode_weight(weights[(voxel.x() * kLeafVoxels + voxel.y()) * kLeafVoxels + voxel.z()]);
    coverage[i] = static_cast<std::uint8_t>(std::lrint(255 * std::sqrt(std::min(1.0f, weight / kWellSeen))));
  }
  return coverage;
}

}  // namespace

LiveMesh::LiveMesh(const TsdfVolume& volume, IncrementalMesher mesher) : mesher_(std::move(mesher)) {
  for (const VolumeBlock& block : volume.index().blocks()) note(volume, block.origin);
}

void LiveMesh::note(const TsdfVolume& volume, const openvdb::Coord& leaf) {
  states_.resize(volume.index().blocks().size());
  const BlockIndex::Number number = volume.index().find(leaf);
  BlockState& state = states_[number];
  if (state.is_waiting) return;
  state.is_waiting = true;
  if (!state.was_meshed && volume.index().blocks()[number].has_matter) {
    new_.push_back(number);
  } else {
    changed_.push_back(number);
  }
}

Result<LiveMesh> LiveMesh::create(const TsdfVolume& volume, const ExtractConfig& config) {
  ExtractConfig live = config;
  if (is_tetrahedral(live.decider)) live.decider = Decider::kTrilinear;  // those have no incremental mesher
  auto mesher = IncrementalMesher::create(view_of(volume), live);
  if (!mesher) return mesher.error();
  return LiveMesh(volume, *std::move(mesher));
}

std::vector<BlockIndex::Number> LiveMesh::take_some(std::size_t most_leaves) {
  std::vector<BlockIndex::Number> some;
  while (some.size() < most_leaves && !new_.empty()) {
    some.push_back(new_.back());
    new_.pop_back();
  }
  while (some.size() < most_leaves && !changed_.empty()) {
    some.push_back(changed_.front());
    changed_.pop_front();
  }
  return some;
}

Result<void> LiveMesh::update(TsdfVolume& volume, std::size_t most_leaves, const Publish& publish) {
  for (const openvdb::Coord& origin : volume.take_changed_blocks()) note(volume, origin);
  std::vector<Eigen::Vector3i> leaves;
  for (const BlockIndex::Number number : take_some(most_leaves)) {
    states_[number] = {.is_waiting = false, .was_meshed = true};
    const openvdb::Coord& origin = volume.index().blocks()[number].origin;
    leaves.emplace_back(origin.x(), origin.y(), origin.z());
  }
  const auto different = mesher_.update(leaves);
  if (!different) return different.error();

  std::set<Eigen::Vector3i, BlockOrder> chunks;
  for (const Eigen::Vector3i& leaf : *different) chunks.insert(chunk_of(leaf));
  for (const Eigen::Vector3i& at : chunks) {
    const auto [chunk, is_new] = chunks_.try_emplace(at);
    if (is_new) chunk->second.number = static_cast<std::uint32_t>(chunks_.size());
    triangles_ -= chunk->second.triangles;
    publish(chunk->second.number, message_of(volume, at, chunk->second));
    triangles_ += chunk->second.triangles;
  }
  return {};
}

std::string LiveMesh::message_of(const TsdfVolume& volume, const Eigen::Vector3i& at, Chunk& chunk) const {
  std::vector<ChunkPart> parts;
  chunk.triangles = 0;
  for (int x = 0; x < kChunkVoxels; x += kLeafVoxels) {
    for (int y = 0; y < kChunkVoxels; y += kLeafVoxels) {
      for (int z = 0; z < kChunkVoxels; z += kLeafVoxels) {
        const auto patch = mesher_.patches().find(at + Eigen::Vector3i(x, y, z));
        if (patch == mesher_.patches().end()) continue;
        chunk.triangles += patch->second.mesh.triangles.size();
        parts.push_back({&patch->second.mesh, coverage_of(volume, patch->second)});
      }
    }
  }
  const auto revision = static_cast<std::uint32_t>(mesher_.revision());
  if (parts.empty()) return chunk_gone_message(chunk.number, revision);
  const float step_m = step_for(static_cast<float>((kChunkVoxels + 2) * volume.config().voxel_size_m));
  return chunk_message(chunk.number, revision, parts, step_m);
}

}  // namespace scanknit
