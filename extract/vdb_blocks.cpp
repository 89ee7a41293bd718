#include "extract/vdb_blocks.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

namespace scanknit {
namespace {

using openvdb::Coord;
using FieldLeaf = openvdb::FloatTree::LeafNodeType;
static_assert(FieldLeaf::DIM == kBlockCells, "a block is a leaf");

struct GridToWorld {
  double voxel_size_m;
  Eigen::Vector3d translation_m;
};

/// Nothing, unless the map is p -> s p + t with a positive s and every world point fits a float.
std::optional<GridToWorld> uniform_map(const openvdb::math::Transform& transform) {
  if (!transform.isLinear()) return std::nullopt;
  const openvdb::Mat4d m = transform.baseMap()->getAffineMap()->getMat4();  // acts on row vectors
  const double scale = m[0][0];
  constexpr double kRoundingOfScale = 1e-9;  // a file may store each axis rounded by itself
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      const double expected = row == column ? scale : 0.0;
      if (!(std::abs(m[row][column] - expected) <= kRoundingOfScale * scale)) return std::nullopt;
    }
  }
  const Eigen::Vector3d translation(m[3][0], m[3][1], m[3][2]);
  constexpr double kMaxIndex = 2147483648.0;  // OpenVDB's coordinates are 32-bit
  const double reach = scale * kMaxIndex + translation.cwiseAbs().maxCoeff();
  const bool fits = scale >= std::numeric_limits<float>::min() && reach <= std::numeric_limits<float>::max();
  if (!fits || !translation.allFinite()) return std::nullopt;
  return GridToWorld{scale, translation};
}

/// Whether the coordinates of the leaves round the one at `origin`, and of their voxels, fit an int.
bool has_room_around(const Eigen::Vector3i& origin) {
  constexpr int kReach = 2 * kBlockCells;
  return origin.minCoeff() >= std::numeric_limits<int>::min() + kReach &&
         origin.maxCoeff() <= std::numeric_limits<int>::max() - kReach;
}

Error config_error(const char* message) {
  return {ErrorCode::kConfig, message, "volume"};
}

/// The part of a block that lies in the neighbouring leaf at offset -1, 0 or +1 along one axis.
struct Overlap {
  int in_block;  ///< the first coordinate in the block
  int in_leaf;   ///< the same voxel's coordinate in that leaf
  int length;
};
constexpr Overlap overlap(int offset) {
  if (offset < 0) return {-1, kBlockCells - 1, 1};
  if (offset == 0) return {0, 0, kBlockCells};
  return {kBlockCells, 0, 2};
}

/// Calls copy_row(leaf_at(leaf origin), 8 x + y and first z in that leaf, destination) for every row of the block in
/// each of the 27 leaves that it overlaps.
template <typename LeafAt, typename Block, typename CopyRow>
void for_each_row(const LeafAt& leaf_at, const Eigen::Vector3i& origin, Block& block, const CopyRow& copy_row) {
  for (int neighbour = 0; neighbour < 27; ++neighbour) {
    const Eigen::Vector3i offset(neighbour / 9 - 1, neighbour / 3 % 3 - 1, neighbour % 3 - 1);
    const Overlap along_x = overlap(offset.x());
    const Overlap along_y = overlap(offset.y());
    const Overlap along_z = overlap(offset.z());
    const Eigen::Vector3i at = origin + kBlockCells * offset;
    const auto leaf = leaf_at(Coord(at.x(), at.y(), at.z()));
    for (int x = 0; x < along_x.length; ++x) {
      for (int y = 0; y < along_y.length; ++y) {
        const int leaf_row = kBlockCells * (along_x.in_leaf + x) + along_y.in_leaf + y;
        auto to = block.row(along_x.in_block + x, along_y.in_block + y, along_z.in_block);
        copy_row(leaf, static_cast<unsigned>(leaf_row), static_cast<unsigned>(along_z.in_leaf),
                 to.first(static_cast<std::size_t>(along_z.length)));
      }
    }
  }
}

/// A leaf of the field, and the leaf of weights that says which of its voxels were observed; where the weight is
/// constant or not given, the active ones were.
struct ObservedLeaf {
  const FieldLeaf* field = nullptr;
  const FieldLeaf* weight = nullptr;
};

}  // namespace

VdbBlocks::VdbBlocks(const FieldView& view, double min_weight, double voxel_size_m,
                     const Eigen::Vector3d& translation_m)
    : view_(view), min_weight_(min_weight), voxel_size_m_(voxel_size_m), translation_m_(translation_m) {}

Result<VdbBlocks> VdbBlocks::open(const FieldView& view, double min_weight) {
  const auto map = uniform_map(view.field->transform());
  if (!map) return config_error("its transform must be a uniform scale and a translation; resample it first");
  if ((view.weight != nullptr && view.weight->transform() != view.field->transform()) ||
      (view.colour != nullptr && view.colour->transform() != view.field->transform())) {
    return config_error("the field, weight and colour grids must have the same transform");
  }

  VdbBlocks blocks(view, min_weight, map->voxel_size_m, map->translation_m);
  if (view.field->tree().activeTileCount() > 0) {
    constexpr openvdb::Index64 kMaxUnfoldedVoxels = openvdb::Index64{1} << 31;  // 8 GiB of floats
    if (view.field->activeVoxelCount() > kMaxUnfoldedVoxels)
      return Error{ErrorCode::kBudget, "its constant regions hold more than 2^31 voxels; crop it first", "volume"};
    const auto unfolded = view.field->deepCopy();
    unfolded->tree().voxelizeActiveTiles();
    blocks.unfolded_ = unfolded;
    blocks.view_.field = unfolded.get();
  }
  blocks.origins_.reserve(blocks.view_.field->tree().leafCount());
  for (auto leaf = blocks.view_.field->tree().cbeginLeaf(); leaf; ++leaf) {
    const Coord origin = leaf->origin();
    blocks.origins_.emplace_back(origin.x(), origin.y(), origin.z());
  }
  if (!std::all_of(blocks.origins_.begin(), blocks.origins_.end(), has_room_around))
    return config_error("it reaches the end of OpenVDB's 32-bit coordinates; move it towards the origin first");
  std::sort(blocks.origins_.begin(), blocks.origins_.end(), is_before);
  return blocks;
}

void VdbBlocks::load_values(std::size_t block, ValueBlock& values) const {
  const auto fields = view_.field->getConstAccessor();
  std::optional<openvdb::FloatGrid::ConstAccessor> weights;
  if (view_.weight != nullptr) weights.emplace(view_.weight->getConstAccessor());
  const auto is_heavy = [this](float weight) { return weight > 0 && static_cast<double>(weight) >= min_weight_; };

  const auto leaf_at = [&](const Coord& origin) {
    ObservedLeaf leaf{fields.probeConstLeaf(origin)};
    if (!weights || leaf.field == nullptr) return leaf;
    leaf.weight = weights->probeConstLeaf(origin);
    const bool is_constant_and_light = leaf.weight == nullptr && !is_heavy(weights->getValue(origin));
    return is_constant_and_light ? ObservedLeaf{} : leaf;
  };
  const auto copy_row = [&](const ObservedLeaf& leaf, unsigned row, unsigned z, std::span<float> to) {
    if (leaf.field == nullptr) return std::fill(to.begin(), to.end(), kUnobserved);
    const float* value = leaf.field->buffer().data() + kBlockCells * row + z;
    const float* weight = leaf.weight != nullptr ? leaf.weight->buffer().data() + kBlockCells * row + z : nullptr;
    const unsigned active = unsigned{leaf.field->valueMask().getWord<std::uint8_t>(static_cast<int>(row))} >> z;
    for (std::size_t i = 0; i < to.size(); ++i) {
      const bool observed = weight != nullptr ? is_heavy(weight[i]) : ((active >> i) & 1) != 0;
      to[i] = observed && std::isfinite(value[i]) ? value[i] : kUnobserved;
    }
  };
  for_each_row(leaf_at, origins_[block], values, copy_row);
}

void VdbBlocks::load_colours(std::size_t block, ColourBlock& colours) const {
  using ColourLeaf = openvdb::Vec3STree::LeafNodeType;
  const auto accessor = view_.colour->getConstAccessor();
  const auto copy_row = [](const ColourLeaf* leaf, unsigned row, unsigned z, std::span<Eigen::Vector3f> to) {
    if (leaf == nullptr) return std::fill(to.begin(), to.end(), no_colour());
    const openvdb::Vec3s* from = leaf->buffer().data() + kBlockCells * row + z;
    for (std::size_t i = 0; i < to.size(); ++i) {
      const Eigen::Vector3f colour(from[i].x(), from[i].y(), from[i].z());
      to[i] = colour.allFinite() && colour.minCoeff() >= 0 ? colour : no_colour();
    }
  };
  for_each_row([&](const Coord& origin) { return accessor.probeConstLeaf(origin); }, origins_[block], colours,
               copy_row);
}

}  // namespace scanknit
