// SilenceWatch: when a camera that sends nothing good is started again, and when it is given up.
#pragma once

#include <chrono>
#include <cstdint>

namespace scanknit {

/// For drivers whose library does not look itself. Times are steady_now_ns(). Not thread-safe.
class SilenceWatch {
 public:
  enum class Verdict { kNothing, kRestart, kRecovered, kGiveUp };

  /// Longer than any camera takes to its first picture.
  static constexpr std::chrono::nanoseconds kSilence = std::chrono::seconds(2);
  static constexpr int kMostRestarts = 2;  ///< in a row, without a good picture between them

  explicit SilenceWatch(std::int64_t started_ns) : started_ns_(started_ns), looked_ns_(started_ns) {}

  /// To be asked several times a second. `picture_ns`: the last good picture of the stream that has waited longest for
  /// one; anything earlier than the start when none came. kRestart: the camera is to be started again, and restarted()
  /// to be called.
  [[nodiscard]] Verdict look(std::int64_t picture_ns, std::int64_t now_ns);

  void restarted(std::int64_t now_ns) { started_ns_ = looked_ns_ = now_ns; }

  /// Without a good picture between them.
  [[nodiscard]] int restarts() const { return restarts_; }

 private:
  std::int64_t started_ns_, looked_ns_;
  int restarts_ = 0;
};

}  // namespace scanknit
