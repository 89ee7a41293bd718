#include "scan/frames/frames_again.h"

#include <algorithm>
#include <vector>

namespace scanknit {

Result<void> FramesAgain::for_each_of(std::span<const std::uint64_t> sequences, const Visit& visit) {
  if (sequences.empty()) return {};
  if (!source_ || (last_read_ && sequences.front() <= *last_read_)) {
    auto source = archive_.open();
    if (!source) return source.error();
    source_ = *std::move(source);
    last_read_.reset();
  }
  return for_each_frame(*source_, stop_, [&](Frame& frame) -> Result<Reading> {
    const std::uint64_t sequence = frame.sequence;
    last_read_ = sequence;
    Result<Reading> reading = Reading::kContinue;
    if (std::binary_search(sequences.begin(), sequences.end(), sequence)) reading = visit(frame);
    return reading && sequence >= sequences.back() ? Result<Reading>(Reading::kStop) : reading;
  });
}

Result<void> FramesAgain::for_each_backwards(std::span<const std::uint64_t> sequences, const Visit& visit) {
  while (!sequences.empty()) {
    const std::size_t count = std::min(sequences.size(), kMostKept);
    std::vector<Frame> frames;
    const auto read = for_each_of(sequences.last(count), [&](Frame& frame) -> Result<Reading> {
      frames.push_back(std::move(frame));
      return Reading::kContinue;
    });
    if (!read) return read;
    for (; !frames.empty(); frames.pop_back()) {
      if (stop_.stop_requested()) return {};
      const auto reading = visit(frames.back());
      if (!reading) return reading.error();
      if (*reading == Reading::kStop) return {};
    }
    sequences = sequences.first(sequences.size() - count);
  }
  return {};
}

}  // namespace scanknit
