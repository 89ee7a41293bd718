// SilenceWatch: decides when to restart a camera that sends no good picture, and when to give it up.
#pragma once

#include <chrono>
#include <cstdint>

namespace scanknit {

/// For drivers whose library does not check this itself. Times are those of steady_now_ns(). Not thread-safe.
class SilenceWatch {
 public:
  enum class Verdict { kNothing, kRestart, kRecovered, kGiveUp };

  /// Longer than any camera needs for its first picture.
  static constexpr std::chrono::nanoseconds kSilence = std::chrono::seconds(2);
  static constexpr int kMostRestarts = 2;  ///< in a row, without a good picture between them

  explicit SilenceWatch(std::int64_t started_ns) : started_ns_(started_ns), looked_ns_(started_ns) {}

  /// To be called several times a second. `picture_ns`: the time of the last good picture, of the stream whose last one
  /// is oldest; any time before the start if there was none. kRestart: restart the camera and call restarted().
  [[nodiscard]] Verdict look(std::int64_t picture_ns, std::int64_t now_ns);

  void restarted(std::int64_t now_ns) { started_ns_ = looked_ns_ = now_ns; }

  /// The number of restarts in a row, without a good picture between them.
  [[nodiscard]] int restarts() const { return restarts_; }

 private:
  std::int64_t started_ns_, looked_ns_;
  int restarts_ = 0;
};

}  // namespace scanknit
