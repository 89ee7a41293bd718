// Pairing: which colour picture belongs to which depth picture.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>

#include "acquire/raw_frame.h"

namespace scanknit {

/// How far apart in device time depth and its colour may be: half a colour period (of 30 a second when unknown).
[[nodiscard]] std::int64_t pairing_reach_ns(const StreamProfile& colour);

/// The index of the time nearest to `time_ns` (the earlier of two equally near) that is not farther than `reach_ns`.
/// `times_ns` ascend.
[[nodiscard]] std::optional<std::size_t> nearest_in_time(std::span<const std::int64_t> times_ns, std::int64_t time_ns,
                                                         std::int64_t reach_ns);

struct RawPair {
  RawFrame depth;
  std::optional<RawFrame> colour;
};

/// The same rule while pictures arrive. Each stream comes in the order of its device time, the two in any order; a
/// picture that is not later than the one before it in its stream is left out of the pairing (colour) or paired as it
/// is (depth). One colour picture may serve several depth pictures. Not thread-safe.
class FramePairing {
 public:
  /// Without a colour stream every depth picture is settled at once.
  explicit FramePairing(bool has_colour) : has_colour_(has_colour) {}

  /// Whether colour is to be waited for from now on: its stream may end before that of depth, and come back.
  void expect_colour(bool is_expected) { has_colour_ = is_expected; }

  void add(RawFrame frame);

  /// The next depth picture whose colour is settled: a colour picture at or after its time has come, or none is to be
  /// expected any more because three depth pictures wait.
  [[nodiscard]] std::optional<RawPair> next();

  /// The same at the end of the streams: nothing is waited for.
  [[nodiscard]] std::optional<RawPair> next_at_end();

 private:
  [[nodiscard]] std::optional<RawPair> pair_first();

  bool has_colour_;
  std::deque<RawFrame> depth_;
  std::deque<RawFrame> colour_;
};

}  // namespace scanknit
