#include "fusion/volume/block_index.h"

#include <algorithm>
#include <array>

namespace scanknit {
namespace {

using openvdb::Coord;

/// Which of a region's blocks.
std::size_t place_of(const Coord& origin) {
  constexpr int kLast = BlockIndex::kRegionBlocks - 1;
  const auto along = [&](int axis) { return static_cast<std::size_t>((origin[axis] >> 3) & kLast); };
  return (along(0) * BlockIndex::kRegionBlocks + along(1)) * BlockIndex::kRegionBlocks + along(2);
}

/// Mixes the bits of multiples of 64 (Steele, Lea, Flood 2014: SplitMix64's finaliser).
std::size_t hash_of(const Coord& origin) {
  const auto part = [](int v) { return static_cast<std::uint64_t>(static_cast<std::uint32_t>(v) >> 6); };
  std::uint64_t h = part(origin.x()) << 42 ^ part(origin.y()) << 21 ^ part(origin.z());
  h = (h ^ (h >> 30)) * 0xBF58476D1CE4E5B9u;
  h = (h ^ (h >> 27)) * 0x94D049BB133111EBu;
  return static_cast<std::size_t>(h ^ (h >> 31));
}

}  // namespace

const ColourCode* colours_of(const ColourLeaf& leaf) {
  static constexpr std::array<ColourCode, ColourLeaf::SIZE> kNone{};
  return has_own_colours(leaf) ? leaf.buffer().data() : kNone.data();
}

BlockIndex::Region::Region(const Coord& lowest) : origin(lowest) {
  numbers.fill(kNone);
}

BlockIndex::Number BlockIndex::find(const Coord& origin) const {
  const Number region = find_region(origin & ~(kRegionVoxels - 1));
  return region == kNone ? kNone : regions_[region]->numbers[place_of(origin)];
}

void BlockIndex::add(const VolumeBlock& block) {
  const auto number = static_cast<Number>(blocks_.size());
  blocks_.push_back(block);
  const Coord origin = block.origin & ~(kRegionVoxels - 1);
  Number region = find_region(origin);
  if (region == kNone) {
    region = static_cast<Number>(regions_.size());
    regions_.push_back(std::make_unique<Region>(origin));
    enter_last_region();
  }
  regions_[region]->blocks.push_back(number);
  regions_[region]->numbers[place_of(block.origin)] = number;
}

BlockIndex::Number BlockIndex::find_region(const Coord& origin) const {
  if (slots_.empty()) return kNone;
  const std::size_t last = slots_.size() - 1;  // a power of two less one
  for (std::size_t slot = hash_of(origin) & last;; slot = (slot + 1) & last) {
    const Number number = slots_[slot];
    if (number == kNone || regions_[number]->origin == origin) return number;
  }
}

void BlockIndex::enter_last_region() {
  constexpr std::size_t kLeast = 1024;
  if (2 * regions_.size() > slots_.size()) {
    slots_.assign(std::max(kLeast, 2 * slots_.size()), kNone);
    for (std::size_t number = 0; number + 1 < regions_.size(); ++number) enter_region(static_cast<Number>(number));
  }
  enter_region(static_cast<Number>(regions_.size() - 1));
}

void BlockIndex::enter_region(Number number) {
  const std::size_t last = slots_.size() - 1;
  std::size_t slot = hash_of(regions_[number]->origin) & last;
  while (slots_[slot] != kNone) slot = (slot + 1) & last;
  slots_[slot] = number;
}

}  // namespace scanknit
