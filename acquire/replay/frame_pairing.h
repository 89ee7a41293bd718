// Pairs each depth picture with its colour picture.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "acquire/raw_frame.h"

namespace scanknit {

/// The largest difference in device time between depth and its colour: half a colour period (at 30 a second if
/// unknown).
[[nodiscard]] std::int64_t pairing_reach_ns(const StreamProfile& colour);

/// The index of the time nearest to `time_ns` (the earlier of two equally near ones) within `reach_ns`. `times_ns`
/// ascend.
[[nodiscard]] std::optional<std::size_t> nearest_in_time(std::span<const std::int64_t> times_ns, std::int64_t time_ns,
                                                         std::int64_t reach_ns);

/// For each time of depth the index of the colour picture that is nearest within `reach_ns`. The times of either stream
/// may come in any order; of colour pictures of one time the first is taken.
[[nodiscard]] std::vector<std::optional<std::size_t>> pair_by_time(std::span<const std::int64_t> depth_ns,
                                                                   std::span<const std::int64_t> colour_ns,
                                                                   std::int64_t reach_ns);

struct RawPair {
  RawFrame depth;
  std::optional<RawFrame> colour;
};

/// Applies the same rule to arriving pictures. Each stream arrives in the order of its device time; the order between
/// streams does not matter. A picture that is not later than its predecessor is not used (colour), or paired by its own
/// time (depth). One colour picture may belong to several depth pictures. Not thread-safe.
class FramePairing {
 public:
  /// Without a colour stream, next() gives every depth picture at once.
  explicit FramePairing(bool has_colour) : has_colour_(has_colour) {}

  /// Sets whether to wait for colour from now on: the colour stream may end before that of depth, and return.
  void expect_colour(bool is_expected) { has_colour_ = is_expected; }

  void add(RawFrame frame);

  /// The next depth picture whose colour is decided: a colour picture at or after its time has arrived, or three depth
  /// pictures wait, so that none is expected.
  [[nodiscard]] std::optional<RawPair> next();

  /// The same at the end of the streams, without waiting for colour.
  [[nodiscard]] std::optional<RawPair> next_at_end();

 private:
  [[nodiscard]] std::optional<RawPair> pair_first();

  bool has_colour_;
  std::deque<RawFrame> depth_;
  std::deque<RawFrame> colour_;
};

}  // namespace scanknit
