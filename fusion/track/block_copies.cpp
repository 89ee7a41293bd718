// Compiled once for each instruction set by Highway, which includes this file again through foreach_target.h.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fusion/track/block_copies.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <cstring>
#include <limits>

#include "fusion/track/block_copies.h"

HWY_BEFORE_NAMESPACE();
namespace scanknit::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void copy_distances(const TsdfLeaf& leaf, float* copy) {
  const hn::CappedTag<float, 8> f;
  constexpr std::size_t kMaskBytes = TsdfLeaf::SIZE / 8;
  std::array<std::uint8_t, kMaskBytes + 8> observed{};  // eight bytes are read at once
  for (openvdb::Index word = 0; word < kMaskBytes / 8; ++word) {
    const auto bits = leaf.getValueMask().getWord<std::uint64_t>(word);
    std::memcpy(observed.data() + 8 * word, &bits, sizeof bits);
  }
  const float* values = leaf.buffer().data();
  const auto unknown = hn::Set(f, std::numeric_limits<float>::quiet_NaN());
  for (std::size_t row = 0; row < kMaskBytes; ++row) {
    for (std::size_t lane = 0; lane < 8; lane += hn::Lanes(f)) {
      const std::array<std::uint8_t, 8> bits{static_cast<std::uint8_t>(observed[row] >> lane)};
      const std::size_t at = 8 * row + lane;
      hn::StoreU(hn::IfThenElse(hn::LoadMaskBits(f, bits.data()), hn::LoadU(f, values + at), unknown), f, copy + at);
    }
  }
}

}  // namespace scanknit::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scanknit {
HWY_EXPORT(copy_distances);

TileSamples::TileSamples(const BlockIndex& index)
    : index_(index), distances_(std::numeric_limits<float>::quiet_NaN()), colours_(0), copied_(1, BlockIndex::kNone) {}

void TileSamples::clear() {
  distances_.clear();
  colours_.clear();
  copied_.resize(1);
}

std::int32_t TileSamples::add_distances(BlockIndex::Number number) {
  const VolumeBlock& block = index_.blocks()[number];
  const std::int32_t start = distances_.add(block.origin);
  copied_.push_back(number);
  HWY_DYNAMIC_DISPATCH(copy_distances)(*block.tsdf, distances_.samples_at(start));
  return start;
}

std::int32_t TileSamples::distances_round(const openvdb::Coord& sample) {
  if (distances_.contains(sample)) return distances_.start_of(sample);
  const BlockIndex::Number number = block_round(sample);
  return number == BlockIndex::kNone ? distances_.add_empty(sample) : add_distances(number);
}

std::int32_t TileSamples::colours_round(const openvdb::Coord& sample) {
  if (colours_.contains(sample)) return colours_.start_of(sample);
  const BlockIndex::Number number = block_round(sample);
  if (number == BlockIndex::kNone) return colours_.add_empty(sample);
  const ColourLeaf& leaf = *index_.blocks()[number].colour;
  if (!has_own_colours(leaf)) return colours_.add_empty(sample);
  const std::int32_t start = colours_.add(sample);
  std::copy_n(leaf.buffer().data(), ColourLeaf::SIZE, colours_.samples_at(start));
  return start;
}

BlockIndex::Number TileSamples::block_round(const openvdb::Coord& sample) const {
  if (!distances_.contains(sample)) return index_.find(sample & ~7);
  return copied_[static_cast<std::size_t>(distances_.start_of(sample)) / TsdfLeaf::SIZE];
}

}  // namespace scanknit
#endif
