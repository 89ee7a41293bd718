// Pace: how fast a recording is played.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>

#include "acquire/frame_source.h"

namespace scanknit {

enum class Pace {
  kFast,      ///< as fast as frames are asked for
  kRealtime,  ///< by the recording's clock, no frame before its time; a slow reader gets all frames, but later
  kStepped,   ///< one frame for each call of PaceControl::wait_for_step
};

/// The result of waiting for a step.
enum class Step {
  kTaken,
  kNotYet,
  kNoMore,  ///< no step will come
};

/// The functions that wait; tests use their own clock.
struct PaceControl {
  std::function<std::chrono::steady_clock::time_point()> now;
  /// Waits until that time, or until stopped.
  std::function<void(std::chrono::steady_clock::time_point, const std::stop_token&)> wait_until;
  /// Waits for at most that long. kNoMore, also returned when stopped, ends the source.
  std::function<Step(const std::stop_token&, std::chrono::milliseconds)> wait_for_step;
};

/// Uses the steady clock; every step comes at once.
[[nodiscard]] PaceControl steady_pace_control();

/// Plays `source` at that pace. Every pace gives the same frames, and therefore the same mesh. Realtime: the first
/// frame sets both clocks; thirty frames a second where the recording has no clock.
[[nodiscard]] std::unique_ptr<FrameSource> paced(std::unique_ptr<FrameSource> source, Pace pace, PaceControl control);

}  // namespace scanknit
