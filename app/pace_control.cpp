#include "app/pace_control.h"

#include <poll.h>
#include <unistd.h>

namespace scanknit {
namespace {

constexpr int kPatience_ms = 100;  // between two looks at the stop token

// True when Enter was pressed; false when stdin has ended or `stop` was requested.
bool wait_for_enter(const std::stop_token& stop) {
  pollfd input{STDIN_FILENO, POLLIN, 0};
  while (!stop.stop_requested()) {
    const int ready = ::poll(&input, 1, kPatience_ms);
    if (ready <= 0) continue;  // nothing yet, or interrupted
    char letter = '\0';
    if (::read(STDIN_FILENO, &letter, 1) != 1) return false;
    if (letter == '\n') return true;
  }
  return false;
}

}  // namespace

PaceControl terminal_pace_control() {
  PaceControl control = steady_pace_control();
  control.wait_for_step = wait_for_enter;
  return control;
}

}  // namespace scanknit
