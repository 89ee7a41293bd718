// RawFrameWriter: what a Recorder writes a scanner's frames with.
#pragma once

#include <cstdint>

#include "acquire/raw_frame.h"
#include "core/result.h"

namespace scanknit {

/// Not thread-safe. A failed call loses the waiting frames (see frames_waiting); everything written before is intact.
class RawFrameWriter {
 public:
  virtual ~RawFrameWriter() = default;

  /// To be called once, first.
  [[nodiscard]] virtual Result<void> begin() = 0;

  /// Adds the frame to those that wait, and writes these when they are many.
  [[nodiscard]] virtual Result<void> write(const RawFrame& frame) = 0;
  virtual void write_losses(std::int64_t host_ns, const LossCounters& losses) = 0;

  /// Frames that are not yet written.
  [[nodiscard]] virtual std::uint64_t frames_waiting() const = 0;
  [[nodiscard]] virtual Result<void> flush() = 0;
  /// The object must not be used after this.
  [[nodiscard]] virtual Result<void> finish() = 0;
};

}  // namespace scanknit
