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
  kRealtime,  ///< by the recording's clock, no frame before its time; a slow reader gets all of them, later
  kStepped,   ///< one frame for each call of PaceControl::wait_for_step
};

/// What became of waiting for a step.
enum class Step {
  kTaken,
  kNotYet,
  kNoMore,  ///< none will come
};

/// Where the waiting is done; tests have a clock of their own.
struct PaceControl {
  std::function<std::chrono::steady_clock::time_point()> now;
  /// Returns at that time, or at once when stopped.
  std::function<void(std::chrono::steady_clock::time_point, const std::stop_token&)> wait_until;
  /// Waits for that long at most. kNoMore, also when stopped, ends the source.
  std::function<Step(const std::stop_token&, std::chrono::milliseconds)> wait_for_step;
};

/// The steady clock; steps that come at once.
[[nodiscard]] PaceControl steady_pace_control();

/// `source` at that pace: the same frames at any of them, so that what is made of them is the same. Realtime: the first
/// frame sets both clocks; thirty frames a second where the recording has no clock.
[[nodiscard]] std::unique_ptr<FrameSource> paced(std::unique_ptr<FrameSource> source, Pace pace, PaceControl control);

}  // namespace scanknit
