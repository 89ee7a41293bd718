// Lets the user at the terminal set the pace of a replay.
#pragma once

#include "acquire/replay/paced_source.h"

namespace scanknit {

/// Uses the steady clock. Each line on stdin is one step; the end of stdin is the last one.
[[nodiscard]] PaceControl terminal_pace_control();

}  // namespace scanknit
