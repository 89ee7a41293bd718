#include "scan/frames/sequence_ranges.h"

#include <algorithm>
#include <utility>

namespace scanknit {

void SequenceRanges::add(std::uint64_t sequence) {
  const bool begins = std::exchange(is_cut_, false) || ranges_.empty();
  if (begins) ranges_.push_back({sequence, sequence});
  Range& range = ranges_.back();
  range.first = std::min(range.first, sequence);
  range.last = std::max(range.last, sequence);
}

void SequenceRanges::clear() {
  ranges_.clear();
  is_cut_ = false;
}

bool SequenceRanges::contains(std::uint64_t sequence) const {
  const auto after = std::upper_bound(ranges_.begin(), ranges_.end(), sequence,
                                      [](std::uint64_t value, const Range& range) { return value < range.first; });
  return after != ranges_.begin() && sequence <= std::prev(after)->last;
}

bool SequenceRanges::end_before(std::uint64_t sequence) const {
  return ranges_.empty() || ranges_.back().last < sequence;
}

std::size_t SequenceRanges::size() const {
  std::size_t size = 0;
  for (const Range& range : ranges_) size += static_cast<std::size_t>(range.last - range.first + 1);
  return size;
}

}  // namespace scanknit
