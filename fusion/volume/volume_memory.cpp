#include "fusion/volume/volume_memory.h"

#include "fusion/fusion_config.h"
#include "fusion/volume/block_index.h"

namespace scanknit {
namespace {

using openvdb::Coord;

template <typename Grid>
using UpperNode = typename Grid::TreeType::RootNodeType::ChildNodeType;
template <typename Grid>
using LowerNode = typename UpperNode<Grid>::ChildNodeType;

constexpr std::size_t kHeap = 16;  // what malloc keeps for itself

template <typename Grid>
constexpr std::size_t leaf_bytes() {
  using Leaf = typename Grid::TreeType::LeafNodeType;
  return sizeof(Leaf) + kHeap;
}
template <typename Grid>
constexpr std::size_t buffer_bytes() {
  using Leaf = typename Grid::TreeType::LeafNodeType;
  return Leaf::SIZE * sizeof(typename Leaf::ValueType) + kHeap;
}

/// A leaf of each grid; its entry in the list, which grows by doubling; its number in its region, likewise.
constexpr std::size_t kBlockBytes =
    leaf_bytes<TsdfGrid>() + leaf_bytes<WeightCodeGrid>() + leaf_bytes<ColourCodeGrid>() + buffer_bytes<TsdfGrid>() +
    buffer_bytes<WeightCodeGrid>() + 2 * sizeof(VolumeBlock) + 2 * sizeof(BlockIndex::Number);
constexpr std::size_t kColoursBytes = buffer_bytes<ColourCodeGrid>();
/// A region of the index; at most four slots in the table.
constexpr std::size_t kRegionBytes = sizeof(BlockIndex::Region) + 2 * sizeof(void*) + 4 * sizeof(BlockIndex::Number);
/// And the regions in the cube of 128^3 voxels, all of which may be needed.
constexpr std::size_t kLowerBytes = sizeof(LowerNode<TsdfGrid>) + sizeof(LowerNode<WeightCodeGrid>) +
                                    sizeof(LowerNode<ColourCodeGrid>) + 8 * kRegionBytes;
static_assert(LowerNode<TsdfGrid>::DIM == 2 * BlockIndex::kRegionVoxels);
constexpr std::size_t kUpperBytes =
    sizeof(UpperNode<TsdfGrid>) + sizeof(UpperNode<WeightCodeGrid>) + sizeof(UpperNode<ColourCodeGrid>);
static_assert(8 * (kUpperBytes + kLowerBytes) + 100 * (kBlockBytes + kColoursBytes) < (kLeastMemoryBudgetMib << 20));

Coord lower_origin(const Coord& origin) {
  return origin & ~(static_cast<int>(LowerNode<TsdfGrid>::DIM) - 1);
}
Coord upper_origin(const Coord& origin) {
  return origin & ~(static_cast<int>(UpperNode<TsdfGrid>::DIM) - 1);
}

}  // namespace

std::size_t VolumeMemory::bytes() const {
  return blocks_ * kBlockBytes + coloured_ * kColoursBytes + lower_nodes_.size() * kLowerBytes +
         upper_nodes_.size() * kUpperBytes;
}

std::size_t VolumeMemory::most_bytes() const {
  return bytes() + (blocks_ - coloured_) * kColoursBytes;
}

std::size_t VolumeMemory::most_bytes_with(const Coord& origin) const {
  return most_bytes() + kBlockBytes + kColoursBytes + (lower_nodes_.contains(lower_origin(origin)) ? 0 : kLowerBytes) +
         (upper_nodes_.contains(upper_origin(origin)) ? 0 : kUpperBytes);
}

void VolumeMemory::add(const Coord& origin) {
  ++blocks_;
  lower_nodes_.insert(lower_origin(origin));
  upper_nodes_.insert(upper_origin(origin));
}

bool BlockBudget::admits(const Coord& origin) {
  if (memory_.most_bytes_with(origin) > max_bytes_) {
    is_reached_ = true;
    return false;
  }
  memory_.add(origin);
  return true;
}

}  // namespace scanknit
