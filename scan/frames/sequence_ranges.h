// SequenceRanges: some frames of a recording, by Frame::sequence.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace scanknit {

class SequenceRanges {
 public:
  /// Also what lies between it and those that were added since the last cut(). It is after all from before that.
  void add(std::uint64_t sequence);

  /// What comes next is not joined to what is there.
  void cut() { is_cut_ = true; }

  void clear();

  [[nodiscard]] bool contains(std::uint64_t sequence) const;

  /// None is `sequence` or after it; also when there are none at all.
  [[nodiscard]] bool end_before(std::uint64_t sequence) const;

  /// Sequence numbers, whether or not there is a frame for each.
  [[nodiscard]] std::size_t size() const;

 private:
  struct Range {
    std::uint64_t first = 0, last = 0;  ///< both included
  };
  std::vector<Range> ranges_;  ///< ascending
  bool is_cut_ = false;
};

}  // namespace scanknit
