// ClassifiedBlocks: the signs of all samples of a volume.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "extract/blocks/block.h"
#include "extract/blocks/neighbours.h"

namespace scanknit {

/// Two bits for each voxel, made in parallel.
class ClassifiedBlocks {
 public:
  ClassifiedBlocks(const BlockSource& source, double isovalue);

  [[nodiscard]] std::size_t size() const { return signs_.size(); }
  [[nodiscard]] const BlockSigns& operator[](std::size_t block) const { return signs_[block]; }

  /// True if all samples of the block are observed.
  [[nodiscard]] bool is_whole(std::size_t block) const { return kinds_[block] != Kind::kWithMissing; }

  /// True if neither the block's cells nor its grid edges meet the surface, because the block and its seven neighbours
  /// towards +x, +y, +z are all High or all Low.
  [[nodiscard]] bool is_plain(const Neighbours& neighbours) const;

 private:
  enum class Kind : std::uint8_t { kAllHigh, kAllLow, kMixed, kWithMissing };
  [[nodiscard]] static Kind kind_of(const BlockSigns& signs);

  std::vector<BlockSigns> signs_;
  std::vector<Kind> kinds_;
};

}  // namespace scanknit
