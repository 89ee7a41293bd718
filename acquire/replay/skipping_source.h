// SkippingSource: a source that need not read all frames.
#pragma once

#include <cstdint>
#include <functional>

#include "acquire/frame_source.h"

namespace scanknit {

/// open_recording() gives one.
class SkippingSource : public FrameSource {
 public:
  /// Passes over frames, without reading them, up to the first one whose Frame::sequence is wanted, or to the end.
  virtual void skip_until(const std::function<bool(std::uint64_t sequence)>& is_wanted) = 0;
};

}  // namespace scanknit
