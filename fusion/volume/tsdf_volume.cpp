#include "fusion/volume/tsdf_volume.h"

#include <cmath>
#include <mutex>
#include <string>

#include "fusion/volume/block_index.h"
#include "fusion/volume/new_block.h"
#include "fusion/volume/region_set.h"
#include "fusion/volume/volume_memory.h"

namespace scanknit {
namespace {

void initialise_openvdb() {
  static std::once_flag once;  // registers grid types; openvdb asks for one call per process
  std::call_once(once, [] { openvdb::initialize(); });
}

bool is_positive(double value) {
  return std::isfinite(value) && value > 0;
}

template <typename Grid>
typename Grid::Ptr make_grid(const char* name, const typename Grid::ValueType& background, double voxel_size_m) {
  auto grid = Grid::create(background);
  grid->setName(name);
  grid->setTransform(openvdb::math::Transform::createLinearTransform(voxel_size_m));
  return grid;
}

}  // namespace

TsdfVolume::TsdfVolume() : index_(std::make_unique<BlockIndex>()), memory_(std::make_unique<VolumeMemory>()) {}
TsdfVolume::TsdfVolume(TsdfVolume&&) noexcept = default;
TsdfVolume& TsdfVolume::operator=(TsdfVolume&&) noexcept = default;
TsdfVolume::~TsdfVolume() = default;

Result<TsdfVolume> TsdfVolume::create(const FusionConfig& config) {
  constexpr double kLeastVoxelSize_m = 1e-6;  // finer than any scanner, and OpenVDB's transforms still have an inverse
  if (!std::isfinite(config.voxel_size_m) || config.voxel_size_m < kLeastVoxelSize_m) {
    return Error{ErrorCode::kConfig, "fusion.voxel_size: expected 0.000001 m or more"};
  }
  if (!is_positive(config.truncation_voxels)) return Error{ErrorCode::kConfig, "fusion.truncation: expected > 0"};
  if (!(config.truncation_sigmas >= 0)) return Error{ErrorCode::kConfig, "fusion.truncation_sigmas: expected >= 0"};
  if (!is_positive(config.max_weight)) return Error{ErrorCode::kConfig, "fusion.max_weight: expected > 0"};
  if (config.memory_budget_mib > kMostMemoryBudgetMib) {
    return Error{ErrorCode::kConfig,
                 "fusion.memory_budget: expected " + std::to_string(kMostMemoryBudgetMib) + " MiB or less"};
  }
  if (config.memory_budget_mib < kLeastMemoryBudgetMib) {
    return Error{ErrorCode::kConfig, "fusion.memory_budget: " + std::to_string(config.memory_budget_mib) +
                                         " MiB hold next to no voxels; expected " +
                                         std::to_string(kLeastMemoryBudgetMib) +
                                         " MiB or more (the scan of an object takes some 20, of a room some hundred)"};
  }

  initialise_openvdb();
  TsdfVolume volume;
  volume.config_ = config;
  const auto truncation_m = static_cast<float>(config.truncation_voxels * config.voxel_size_m);
  volume.tsdf_ = make_grid<TsdfGrid>("tsdf", truncation_m, config.voxel_size_m);
  volume.weight_ = make_grid<WeightCodeGrid>("weight", WeightCode{0}, config.voxel_size_m);
  volume.colour_ = make_grid<ColourCodeGrid>("colour", ColourCode{0}, config.voxel_size_m);
  return volume;
}

FieldView TsdfVolume::field_view() const {
  FieldView view;
  view.field = tsdf_.get();
  view.weight_codes = weight_.get();
  view.colour_codes = colour_.get();
  return view;
}

Voxel TsdfVolume::voxel(const openvdb::Coord& index) const {
  const ColourCode colour = colour_->tree().getValue(index);
  Voxel voxel{tsdf_->tree().getValue(index), decode_weight(weight_->tree().getValue(index)), {}};
  if (has_colour(colour)) voxel.colour = decode_colour(colour);
  return voxel;
}

std::size_t TsdfVolume::blocks() const {
  return index_->blocks().size();
}

std::size_t TsdfVolume::memory_bytes() const {
  return memory_->bytes();
}

BlockBudget TsdfVolume::block_budget() const {
  return {*memory_, config_.memory_budget_mib << 20};
}

void TsdfVolume::count_colours_of_a_block() {
  memory_->add_colours();
}

void TsdfVolume::add_block(NewBlock added) {
  const VolumeBlock& block = added.block;
  tsdf_->tree().addLeaf(added.tsdf.release());
  weight_->tree().addLeaf(added.weight.release());
  colour_->tree().addLeaf(added.colour.release());
  index_->add(block);
  memory_->add(block.origin);
  if (has_own_colours(*block.colour)) memory_->add_colours();
}

void TsdfVolume::keep_only(const std::unordered_set<openvdb::Coord>& regions) {
  TsdfVolume kept = *create(config_);
  kept.frames = frames;
  kept.is_budget_reached = is_budget_reached;
  for (const VolumeBlock& block : index_->blocks()) {
    if (!regions.contains(region_of(block.origin))) continue;
    NewBlock moved;
    moved.tsdf.reset(tsdf_->tree().stealNode<TsdfLeaf>(block.origin, tsdf_->background(), false));
    moved.weight.reset(weight_->tree().stealNode<WeightLeaf>(block.origin, WeightCode{0}, false));
    moved.colour.reset(colour_->tree().stealNode<ColourLeaf>(block.origin, ColourCode{0}, false));
    moved.block = block;
    kept.add_block(std::move(moved));
  }
  *this = std::move(kept);
}

std::vector<openvdb::Coord> TsdfVolume::take_changed_blocks() {
  std::vector<openvdb::Coord> origins;
  for (VolumeBlock& block : index_->blocks()) {
    if (block.has_changed) origins.push_back(block.origin);
    block.has_changed = false;
  }
  return origins;
}

std::size_t TsdfVolume::active_voxels() const {
  return tsdf_->activeVoxelCount();
}

}  // namespace scanknit
