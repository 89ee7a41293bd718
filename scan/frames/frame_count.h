// How many frames of a recording are selected.
#pragma once

#include <algorithm>
#include <cstddef>

#include "acquire/frame_source.h"

namespace scanknit {

/// The number of frames that `from`, `to` and `every` select.
[[nodiscard]] inline std::size_t selected_frames(const RecordingInfo& info, const AcquireConfig& config) {
  if (info.frames == 0 || config.from >= info.frames || config.to < config.from) return 0;
  const std::size_t last = std::min(config.to, info.frames - 1);
  return (last - config.from) / std::max<std::size_t>(1, config.every) + 1;
}

}  // namespace scanknit
