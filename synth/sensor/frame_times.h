// When a sensor takes its pictures, and which of them arrive.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "synth/sensor/rendered_sensor.h"

namespace scanknit {

/// Moments are counted in frames (see Motion).
struct FrameTime {
  std::size_t stamp = 0;    ///< when the sensor says that the frame was taken: frames are missing, none is out of order
  std::size_t taken = 0;    ///< when its pictures were taken: earlier where they are repeated
  double colour_frame = 0;  ///< when the middle row of its colour picture was
};

/// The frames that arrive of `frames` pictures; the first always does. A pure function.
[[nodiscard]] std::vector<FrameTime> frame_times(const RenderedSensor& sensor, int frames, std::uint64_t seed);

}  // namespace scanknit
