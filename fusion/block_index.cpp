#include "fusion/block_index.h"

#include <algorithm>

namespace scanknit {
namespace {

using openvdb::Coord;

/// Mixes the bits of multiples of 8 (Steele, Lea, Flood 2014: SplitMix64's finaliser).
std::size_t hash_of(const Coord& origin) {
  const auto part = [](int v) { return static_cast<std::uint64_t>(static_cast<std::uint32_t>(v) >> 3); };
  std::uint64_t h = part(origin.x()) << 42 ^ part(origin.y()) << 21 ^ part(origin.z());
  h = (h ^ (h >> 30)) * 0xBF58476D1CE4E5B9u;
  h = (h ^ (h >> 27)) * 0x94D049BB133111EBu;
  return static_cast<std::size_t>(h ^ (h >> 31));
}

}  // namespace

template <typename Thing>
BlockIndex::Number BlockIndex::Table<Thing>::find(const std::vector<Thing>& things, const Coord& origin) const {
  if (slots_.empty()) return kNone;
  const std::size_t last = slots_.size() - 1;  // a power of two less one
  for (std::size_t slot = hash_of(origin) & last;; slot = (slot + 1) & last) {
    const Number number = slots_[slot];
    if (number == kNone || things[number].origin == origin) return number;
  }
}

template <typename Thing>
void BlockIndex::Table<Thing>::enter_last(const std::vector<Thing>& things) {
  constexpr std::size_t kLeast = 1024;
  if (2 * things.size() > slots_.size()) {
    slots_.assign(std::max(kLeast, 2 * slots_.size()), kNone);
    for (std::size_t number = 0; number + 1 < things.size(); ++number) enter(things, static_cast<Number>(number));
  }
  enter(things, static_cast<Number>(things.size() - 1));
}

template <typename Thing>
void BlockIndex::Table<Thing>::enter(const std::vector<Thing>& things, Number number) {
  const std::size_t last = slots_.size() - 1;
  std::size_t slot = hash_of(things[number].origin) & last;
  while (slots_[slot] != kNone) slot = (slot + 1) & last;
  slots_[slot] = number;
}

BlockIndex::Number BlockIndex::find(const Coord& origin) const {
  return block_table_.find(blocks_, origin);
}

void BlockIndex::add(const VolumeBlock& block) {
  const auto number = static_cast<Number>(blocks_.size());
  blocks_.push_back(block);
  block_table_.enter_last(blocks_);

  const Coord origin = block.origin & ~(kRegionVoxels - 1);
  Number region = region_table_.find(regions_, origin);
  if (region == kNone) {
    region = static_cast<Number>(regions_.size());
    regions_.push_back({origin, {}});
    region_table_.enter_last(regions_);
  }
  regions_[region].blocks.push_back(number);
}

}  // namespace scanknit
