// Deadlines, and pauses that a stop request ends, for waiting for cameras.
#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <stop_token>

namespace scanknit {

/// The time so many seconds from now; at most a year.
[[nodiscard]] inline std::chrono::steady_clock::time_point after(double seconds) {
  constexpr double kYear = 31'557'600;
  const auto whole = static_cast<std::int64_t>(std::clamp(seconds, 0.0, kYear) * 1000);
  return std::chrono::steady_clock::now() + std::chrono::milliseconds(whole);
}

/// Waits; false when stopped.
[[nodiscard]] inline bool pause(std::chrono::milliseconds time, const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  never.wait_for(lock, stop, time, [] { return false; });
  return !stop.stop_requested();
}

}  // namespace scanknit
