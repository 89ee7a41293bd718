#include "app/terminal/pace_control.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>

namespace scanknit {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kLongest{100};  // between two checks of the stop token

/// Waits for Enter, which is one step. The end of stdin, or a stop request, ends all waiting.
Step wait_for_enter(const std::stop_token& stop, std::chrono::milliseconds patience) {
  const auto deadline = Clock::now() + patience;
  pollfd input{STDIN_FILENO, POLLIN, 0};
  while (!stop.stop_requested()) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now());
    const int ready = ::poll(&input, 1, static_cast<int>(std::clamp(left, {}, kLongest).count()));
    if (ready <= 0 && Clock::now() >= deadline) return Step::kNotYet;
    if (ready <= 0) continue;  // no input yet, or interrupted
    char letter = '\0';
    if (::read(STDIN_FILENO, &letter, 1) != 1) return Step::kNoMore;
    if (letter == '\n') return Step::kTaken;
  }
  return Step::kNoMore;
}

}  // namespace

PaceControl terminal_pace_control() {
  PaceControl control = steady_pace_control();
  control.wait_for_step = wait_for_enter;
  return control;
}

}  // namespace scanknit
