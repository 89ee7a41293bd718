#include "extract/blocks/classified_blocks.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>

#include "extract/blocks/sign_bytes.h"

namespace scanknit {

ClassifiedBlocks::ClassifiedBlocks(const BlockSource& source, double isovalue)
    : signs_(source.origins().size()), kinds_(signs_.size()) {
  constexpr std::size_t kBlocksPerTask = 128;
  const float limit = float_isovalue(isovalue);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, signs_.size(), kBlocksPerTask), [&](const auto& range) {
    const auto signs = std::span(signs_).subspan(range.begin(), range.size());
    source.classify(range.begin(), limit, signs);
    std::transform(signs.begin(), signs.end(), kinds_.begin() + static_cast<std::ptrdiff_t>(range.begin()), &kind_of);
  });
}

ClassifiedBlocks::Kind ClassifiedBlocks::kind_of(const BlockSigns& signs) {
  std::uint64_t any_high = 0;
  std::uint64_t any_missing = 0;
  std::uint64_t all_high = ~std::uint64_t{0};
  for (std::size_t x = 0; x < kBlockCells; ++x) {
    any_high |= signs.high[x];
    all_high &= signs.high[x];
    any_missing |= signs.missing[x];
  }
  if (any_missing != 0) return Kind::kWithMissing;
  if (any_high == 0) return Kind::kAllLow;
  return ~all_high == 0 ? Kind::kAllHigh : Kind::kMixed;
}

bool ClassifiedBlocks::is_plain(const Neighbours& neighbours) const {
  const Kind kind = kinds_[neighbours.at(0, 0, 0)];
  if (kind != Kind::kAllHigh && kind != Kind::kAllLow) return false;
  for (int upper = 1; upper < 8; ++upper) {
    const std::size_t block = neighbours.at(upper & 1, (upper >> 1) & 1, upper >> 2);
    if (block == kNoBlock || kinds_[block] != kind) return false;
  }
  return true;
}

}  // namespace scanknit
