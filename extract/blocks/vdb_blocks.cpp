#include "extract/blocks/vdb_blocks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "extract/blocks/sign_bytes.h"

namespace scanknit {
namespace {

using openvdb::Coord;
using FieldLeaf = openvdb::FloatTree::LeafNodeType;
static_assert(FieldLeaf::DIM == kBlockCells, "a block is a leaf");

/// Nothing, unless the map is linear, can be inverted, and every world point fits a float.
std::optional<Eigen::Affine3d> linear_map(const openvdb::math::Transform& transform) {
  if (!transform.isLinear()) return std::nullopt;
  const openvdb::Mat4d m = transform.baseMap()->getAffineMap()->getMat4();  // acts on row vectors
  Eigen::Affine3d T_world_index = Eigen::Affine3d::Identity();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) T_world_index.linear()(column, row) = m[row][column];
    T_world_index.translation()[row] = m[3][row];
  }
  constexpr double kMaxIndex = 2147483648.0;  // OpenVDB's coordinates are 32-bit
  const double reach =
      T_world_index.linear().cwiseAbs().maxCoeff() * 3 * kMaxIndex + T_world_index.translation().cwiseAbs().maxCoeff();
  const double shortest = T_world_index.linear().colwise().norm().minCoeff();
  const double volume = std::abs(T_world_index.linear().determinant());
  const bool fits = shortest >= std::numeric_limits<float>::min() && reach <= std::numeric_limits<float>::max();
  if (!fits || !T_world_index.matrix().allFinite() || !(volume > 0)) return std::nullopt;
  return T_world_index;
}

bool can_floats_resolve_all(const Eigen::Affine3d& T_world_index, std::span<const Eigen::Vector3i> origins) {
  const Eigen::RowVector3d edges = T_world_index.linear().colwise().norm();
  double reach = 0;
  for (const Eigen::Vector3i& origin : origins)
    reach = std::max(reach, (T_world_index * origin.cast<double>()).cwiseAbs().maxCoeff());
  return can_floats_resolve(edges.minCoeff(), reach);
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
        const auto row = block.row(along_x.in_block + x, along_y.in_block + y);
        copy_row(leaf, static_cast<unsigned>(leaf_row), static_cast<unsigned>(along_z.in_leaf),
                 row.subspan(static_cast<std::size_t>(along_z.in_block - kBlockFirst),
                             static_cast<std::size_t>(along_z.length)));
      }
    }
  }
}

/// A weight above 0 that is at least min_weight, as one comparison.
float observed_weight(double min_weight) {
  return std::max(float_isovalue(min_weight), std::numeric_limits<float>::denorm_min());
}

/// The least code that decodes to `min_weight` or more.
WeightCode least_code(float min_weight) {
  WeightCode code = encode_weight(min_weight);
  while (code > 1 && decode_weight(static_cast<WeightCode>(code - 1)) >= min_weight) --code;
  while (code < std::numeric_limits<WeightCode>::max() && decode_weight(code) < min_weight) ++code;
  return code;
}

/// A leaf of the field, and the weights or codes that say which of its voxels were observed; where these are constant
/// or not given, the active ones were.
struct ObservedLeaf {
  const FieldLeaf* field = nullptr;  ///< null: no voxel was observed
  const float* weights = nullptr;
  const WeightCode* codes = nullptr;
};

/// Finds observed leaves; for one thread.
class LeafFinder {
 public:
  LeafFinder(const FieldView& view, float min_weight)
      : fields_(view.field->tree()), region_(view.region), min_weight_(min_weight), min_code_(least_code(min_weight)) {
    if (view.weight != nullptr) weights_.emplace(view.weight->tree());
    if (view.weight_codes != nullptr) codes_.emplace(view.weight_codes->tree());
  }

  [[nodiscard]] ObservedLeaf operator()(const Coord& origin) const {
    ObservedLeaf leaf{fields_.probeConstLeaf(origin)};
    if (leaf.field == nullptr) return leaf;
    bool is_light = false;  // throughout
    if (weights_) leaf.weights = data_of(*weights_, origin, min_weight_, is_light);
    if (codes_) leaf.codes = data_of(*codes_, origin, min_code_, is_light);
    return is_light ? ObservedLeaf{} : leaf;
  }

  /// Bit z: voxel z of row `row` = 8 x + y was observed.
  [[nodiscard]] unsigned observed(const ObservedLeaf& leaf, std::size_t row) const {
    return region_ ? weighed(leaf, row) & within_region(leaf.field->origin(), row) : weighed(leaf, row);
  }

 private:
  [[nodiscard]] unsigned weighed(const ObservedLeaf& leaf, std::size_t row) const {
    if (leaf.weights != nullptr) return heavy(leaf.weights + kBlockCells * row, min_weight_);
    if (leaf.codes != nullptr) return heavy(leaf.codes + kBlockCells * row, min_code_);
    return leaf.field->valueMask().getWord<std::uint8_t>(static_cast<int>(row));
  }

  [[nodiscard]] unsigned within_region(const Coord& origin, std::size_t row) const {
    const auto at = static_cast<int>(row);
    const int x = origin.x() + at / kBlockCells;
    const int y = origin.y() + at % kBlockCells;
    if (x < region_->min().x() || x > region_->max().x() || y < region_->min().y() || y > region_->max().y()) return 0;
    unsigned bits = 0;
    for (int z = 0; z < kBlockCells; ++z) {
      const bool is_within = origin.z() + z >= region_->min().z() && origin.z() + z <= region_->max().z();
      bits |= (is_within ? 1u : 0u) << z;
    }
    return bits;
  }

  /// The values of the leaf at `origin`; null where they are constant.
  template <typename Accessor, typename Value>
  static const Value* data_of(const Accessor& values, const Coord& origin, Value least, bool& is_light) {
    const auto* leaf = values.probeConstLeaf(origin);
    if (leaf != nullptr) return leaf->buffer().data();
    is_light = !(values.getValue(origin) >= least);
    return nullptr;
  }

  template <typename Value>
  static unsigned heavy(const Value* row, Value least) {
    unsigned bits = 0;
    for (unsigned z = 0; z < kBlockCells; ++z) bits |= (row[z] >= least ? 1u : 0u) << z;
    return bits;
  }

  openvdb::FloatGrid::ConstAccessor fields_;
  std::optional<openvdb::CoordBBox> region_;
  std::optional<openvdb::FloatGrid::ConstAccessor> weights_;
  std::optional<WeightCodeGrid::ConstAccessor> codes_;
  float min_weight_;
  WeightCode min_code_;
};

Eigen::Vector3f colour_of(const openvdb::Vec3s& value) {
  const Eigen::Vector3f colour(value.x(), value.y(), value.z());
  return colour.allFinite() && colour.minCoeff() >= 0 ? colour : no_colour();
}

Eigen::Vector3f colour_of(ColourCode code) {
  const Rgb8 colour = decode_colour(code);
  return has_colour(code) ? Eigen::Vector3f(colour.r, colour.g, colour.b) / 255 : no_colour();
}

}  // namespace

VdbBlocks::VdbBlocks(const FieldView& view, double min_weight, const Eigen::Affine3d& T_world_index)
    : view_(view), min_weight_(observed_weight(min_weight)), T_world_index_(T_world_index) {}

Result<VdbBlocks> VdbBlocks::open(const FieldView& view, double min_weight) {
  const auto map = linear_map(view.field->transform());
  if (!map)
    return config_error("its transform must be linear and invertible, within reach of floats; resample it first");
  const auto lies_elsewhere = [&](const openvdb::GridBase* grid) {
    return grid != nullptr && grid->transform() != view.field->transform();
  };
  if (lies_elsewhere(view.weight) || lies_elsewhere(view.colour) || lies_elsewhere(view.weight_codes) ||
      lies_elsewhere(view.colour_codes)) {
    return config_error("the field, weight and colour grids must have the same transform");
  }

  VdbBlocks blocks(view, min_weight, *map);
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
  if (!can_floats_resolve_all(*map, blocks.origins_)) return config_error(kTooFarForFloats);
  std::sort(blocks.origins_.begin(), blocks.origins_.end(), is_before);
  return blocks;
}

VdbBlocks VdbBlocks::restricted_to(std::vector<Eigen::Vector3i> origins) const {
  VdbBlocks blocks(view_, static_cast<double>(min_weight_), T_world_index_);
  blocks.unfolded_ = unfolded_;
  const auto accessor = view_.field->getConstAccessor();
  std::erase_if(origins, [&](const Eigen::Vector3i& at) {
    return accessor.probeConstLeaf(Coord(at.x(), at.y(), at.z())) == nullptr;
  });
  blocks.origins_ = std::move(origins);
  return blocks;
}

void VdbBlocks::classify(std::size_t first, float isovalue, std::span<BlockSigns> signs) const {
  const LeafFinder leaf_at(view_, min_weight_);
  constexpr std::size_t kRows = FieldLeaf::SIZE / kBlockCells;
  std::array<std::uint8_t, kRows> high{};
  std::array<std::uint8_t, kRows> missing{};
  for (std::size_t i = 0; i < signs.size(); ++i) {
    const Eigen::Vector3i& origin = origins_[first + i];
    const ObservedLeaf leaf = leaf_at(Coord(origin.x(), origin.y(), origin.z()));
    signs[i].missing.fill(~std::uint64_t{0});
    if (leaf.field == nullptr) continue;
    sign_bytes(leaf.field->buffer().data(), kRows, isovalue, high.data(), missing.data());
    for (std::size_t x = 0; x < kBlockCells; ++x) {
      std::uint64_t is_high = 0;
      std::uint64_t is_missing = 0;
      for (std::size_t y = 0; y < kBlockCells; ++y) {
        const std::size_t row = kBlockCells * x + y;
        const unsigned unobserved = (~leaf_at.observed(leaf, row) | missing[row]) & 0xFFu;
        is_missing |= std::uint64_t{unobserved} << (kBlockCells * y);
        is_high |= std::uint64_t{high[row] & ~unobserved} << (kBlockCells * y);
      }
      signs[i].high[x] = is_high;
      signs[i].missing[x] = is_missing;
    }
  }
}

void VdbBlocks::load_values(std::size_t block, ValueBlock& values) const {
  const LeafFinder leaf_at(view_, min_weight_);
  const auto copy_row = [&](const ObservedLeaf& leaf, unsigned row, unsigned z, std::span<float> to) {
    if (leaf.field == nullptr) return std::fill(to.begin(), to.end(), kUnobserved);
    const float* value = leaf.field->buffer().data() + kBlockCells * row + z;
    const unsigned observed = leaf_at.observed(leaf, row) >> z;
    for (std::size_t i = 0; i < to.size(); ++i) to[i] = ((observed >> i) & 1) != 0 ? value[i] : kUnobserved;
  };
  for_each_row(leaf_at, origins_[block], values, copy_row);
  values.show_buffer();
}

void VdbBlocks::load_colours(std::size_t block, ColourBlock& colours) const {
  const auto load_from = [&](const auto& grid) {
    const auto accessor = grid.getConstAccessor();
    const auto leaf_at = [&](const Coord& origin) { return accessor.probeConstLeaf(origin); };
    const auto copy_row = [](const auto* leaf, unsigned row, unsigned z, std::span<Eigen::Vector3f> to) {
      if (leaf == nullptr || leaf->buffer().empty()) return std::fill(to.begin(), to.end(), no_colour());
      const auto* from = leaf->buffer().data() + kBlockCells * row + z;
      std::transform(from, from + to.size(), to.begin(), [](const auto& value) { return colour_of(value); });
    };
    for_each_row(leaf_at, origins_[block], colours, copy_row);
  };
  if (view_.colour != nullptr) {
    load_from(*view_.colour);
  } else {
    load_from(*view_.colour_codes);
  }
}

}  // namespace scanknit
