// TrackingWatch: warns before a camera is lost.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/frame.h"
#include "core/pose.h"

namespace scanknit {

/// What will soon lose a camera that is still tracked.
struct TrackingCaution {
  const char* reason;  ///< "moving fast"
  const char* advice;  ///< "move more slowly"
};

/// Watches the frames of a live scan, one after the other.
class TrackingWatch {
 public:
  /// Returns a warning if tracking will probably be lost soon. The frame was tracked at `T_world_camera`, using
  /// `points` points.
  [[nodiscard]] std::optional<TrackingCaution> look(const Frame& frame, const Pose& T_world_camera, std::size_t points);

  /// The next frame does not continue the last one.
  void reset() { last_.reset(); }

 private:
  struct Last {
    Pose T_world_camera;
    std::int64_t timestamp_ns;
  };
  std::optional<Last> last_;
};

}  // namespace scanknit
