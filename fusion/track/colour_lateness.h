// ColourLateness: whether a recording's colour is taken with its depth, as the frames so far show.
#pragma once

#include <algorithm>

namespace scanknit {

/// Mean square of how late colour seems to be (IcpResult::colour_seems_later), over frames in which the camera moves.
class ColourLateness {
 public:
  /// `moved_px`: the camera's motion in the picture since the frame before. The more, the better it shows the time.
  void learn(double later_s, double moved_px) {
    constexpr double kSlowly = 0.02;
    const double rate = std::max(kSlowly, 1.0 / ++frames_);
    const double certainty = moved_px * moved_px;
    squares_s2_ += rate * (certainty * later_s * later_s - squares_s2_);
    certainty_ += rate * (certainty - certainty_);
  }

  /// Colour in time seems to be 0.2 to 1.9 ms late, by noise and errors of the pose; late colour, or a rolling
  /// shutter that is not known, mostly 2.5 to 6 ms (docs/fusion.md).
  [[nodiscard]] bool is_none() const {
    constexpr int kFewest = 5;
    constexpr double kMost_s = 0.002;
    return frames_ >= kFewest && squares_s2_ < kMost_s * kMost_s * certainty_;
  }

 private:
  int frames_ = 0;
  double squares_s2_ = 0, certainty_ = 0;  ///< means over frames, the newest ones counting most
};

}  // namespace scanknit
