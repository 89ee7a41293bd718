// The pace of a replay, set by the person at the terminal.
#pragma once

#include "acquire/replay/paced_source.h"

namespace scanknit {

/// The steady clock; a step is a line on stdin, whose end is the last step.
[[nodiscard]] PaceControl terminal_pace_control();

}  // namespace scanknit
