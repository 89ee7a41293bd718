// How two cameras of a rig stand and how their clocks differ, roughly: from the board's motion before both.
#pragma once

#include <cstddef>

#include "calibrate/rig/board_track.h"
#include "core/pose.h"

namespace scanknit {

struct PairGuess {
  Pose T_a_b = Pose::Identity();  ///< p_a = T_a_b * p_b
  double lag_s = 0;               ///< the clock of a shows so much more than that of b
  std::size_t agreeing =
      0;  ///< views of b at whose times a sees the board, too, and with this pose between them; 0 unless most do
};

enum class Clocks { kShared, kFree };

/// kFree: the cameras do not move against each other, so that at the right lag the board's turns before both differ by
/// one and the same rotation; of all lags at which the recordings overlap, the one is taken at which most do. Clocks
/// that differ by no more than 50 ms are preferred if that fits nearly as well. None agree if no motion tells of other
/// ones. Deterministic.
[[nodiscard]] PairGuess guess_pair(const BoardTrack& a, const BoardTrack& b, Clocks clocks);

}  // namespace scanknit
