// SequenceRanges: some frames of a recording, by Frame::sequence.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace scanknit {

class SequenceRanges {
 public:
  /// Adds this number, and all numbers between it and those added since the last cut(). It must be greater than all
  /// numbers that were added before that cut().
  void add(std::uint64_t sequence);

  /// The next number begins a new range.
  void cut() { is_cut_ = true; }

  void clear();

  [[nodiscard]] bool contains(std::uint64_t sequence) const;

  /// True when all numbers are less than `sequence`, and when there are none.
  [[nodiscard]] bool end_before(std::uint64_t sequence) const;

  /// The count of sequence numbers, whether or not there is a frame for each.
  [[nodiscard]] std::size_t size() const;

 private:
  struct Range {
    std::uint64_t first = 0, last = 0;  ///< both included
  };
  std::vector<Range> ranges_;  ///< ascending
  bool is_cut_ = false;
};

}  // namespace scanknit
