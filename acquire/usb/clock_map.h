// The camera's clock: converts its wrapping ticks to nanoseconds that never go back, and to this computer's time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

namespace scanknit {

/// Fits host = a + b * device to pairs of times. The host's times are late by a transport delay that is never negative.
/// The line is below all pairs, with the least sum of distances to them (Moon, Skelly, Towsley 1999, "Estimation and
/// removal of clock skew from network delay measurements", section IV): delays push pairs up and do not move it.
class ClockMap {
 public:
  /// `device_ns` must be larger than all before.
  void add(std::int64_t device_ns, std::int64_t host_ns);
  void clear() { pairs_.clear(); }

  /// Nothing before the first pair.
  [[nodiscard]] std::optional<std::int64_t> host_of(std::int64_t device_ns) const;
  [[nodiscard]] std::optional<std::int64_t> device_of(std::int64_t host_ns) const;

 private:
  struct Pair {
    std::int64_t device_ns, host_ns;
  };
  struct Line {
    Pair through;
    double skew;  // b - 1: small, so that no digits of the times are lost
  };
  [[nodiscard]] std::optional<Line> fit() const;

  std::deque<Pair> pairs_;  // pairs of the last frames
};

/// For one thread.
class DeviceClock {
 public:
  /// `ticks_per_second` >= 1.
  explicit DeviceClock(std::uint32_t ticks_per_second);

  struct Stamp {
    std::int64_t device_ns = 0;  ///< larger than the last one
    bool is_jump = false;        ///< the camera's clock jumped or stood still; the stamp comes from the host's clock
  };

  /// `ticks` wraps at 2^32. Nothing: the frame has no time, and gets this computer's. If the camera's clock and this
  /// computer's differ by more than half a second from one frame to the next, the camera's clock has jumped; the stamps
  /// then continue as if it had not.
  [[nodiscard]] Stamp stamp(std::optional<std::uint32_t> ticks, std::int64_t host_ns);

 private:
  [[nodiscard]] std::int64_t in_ns(std::uint64_t ticks) const;
  [[nodiscard]] Stamp after_jump(std::int64_t host_ns);

  const std::uint32_t ticks_per_second_;
  std::optional<std::uint32_t> last_ticks_;
  std::uint64_t ticks_ = 0;     // unwrapped
  std::int64_t offset_ns_ = 0;  // device_ns = in_ns(ticks_) + offset_ns_
  std::int64_t last_device_ns_ = 0;
  std::int64_t last_host_ns_ = 0;
  bool is_first_ = true;
  ClockMap map_;
};

}  // namespace scanknit
