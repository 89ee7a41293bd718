// Advice for the user on tracking.
#pragma once

#include <string>

#include "fusion/track/tracker.h"

namespace scanknit {

/// What to do about it; empty for kNone.
[[nodiscard]] std::string tracking_advice(TrackReason reason);

}  // namespace scanknit
