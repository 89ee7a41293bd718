// FrameTiming: when a sensor takes the parts of a frame.
#pragma once

namespace scanknit {

/// Zero: all at once. A frame's time is that of the middle row of its depth picture.
struct FrameTiming {
  double readout_s = 0;       ///< from the first row of a picture to the last (rolling shutter), >= 0
  double colour_later_s = 0;  ///< the colour picture is taken so long after the depth picture; < 0: before it

  [[nodiscard]] bool is_at_once() const { return readout_s == 0 && colour_later_s == 0; }
};

}  // namespace scanknit
