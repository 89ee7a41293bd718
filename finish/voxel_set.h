// VoxelSet: some voxels of a box, and their numbers, in a fifth of a byte for each voxel of the box.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace scanknit {

/// Members have numbers from 0, in the order of their indices.
class VoxelSet {
 public:
  VoxelSet() = default;

  /// Of `voxels` voxels, those for which is_member(index). Calls it in parallel.
  template <typename IsMember>
  [[nodiscard]] static VoxelSet where(std::size_t voxels, const IsMember& is_member) {
    VoxelSet set;
    set.words_.resize((voxels + kBits - 1) / kBits);
    tbb::parallel_for(std::size_t{0}, set.words_.size(), [&](std::size_t word) {
      for (std::size_t bit = 0; bit < kBits && word * kBits + bit < voxels; ++bit) {
        if (is_member(word * kBits + bit)) set.words_[word] |= std::uint64_t{1} << bit;
      }
    });
    set.before_.reserve(set.words_.size());
    for (const std::uint64_t word : set.words_) {
      set.before_.push_back(static_cast<std::uint32_t>(set.size_));
      set.size_ += static_cast<std::size_t>(std::popcount(word));
    }
    return set;
  }

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool contains(std::size_t index) const { return (words_[index / kBits] >> index % kBits & 1) != 0; }
  /// The number of a member.
  [[nodiscard]] std::size_t number(std::size_t index) const {
    const std::uint64_t below = words_[index / kBits] & ((std::uint64_t{1} << index % kBits) - 1);
    return before_[index / kBits] + static_cast<std::size_t>(std::popcount(below));
  }

  /// Calls visit(index, number) for each member, in parallel.
  template <typename Visit>
  void for_each(const Visit& visit) const {
    constexpr std::size_t kWordsPerTask = 64;
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, words_.size(), kWordsPerTask), [&](const auto& range) {
      for (std::size_t word = range.begin(); word != range.end(); ++word) {
        std::size_t number = before_[word];
        for (std::uint64_t bits = words_[word]; bits != 0; bits &= bits - 1) {
          visit(word * kBits + static_cast<std::size_t>(std::countr_zero(bits)), number++);
        }
      }
    });
  }

 private:
  static constexpr std::size_t kBits = 64;
  std::vector<std::uint64_t> words_;
  std::vector<std::uint32_t> before_;  ///< members before each word
  std::size_t size_ = 0;
};

}  // namespace scanknit
