// What the pictures of a turntable say of angles that are known from elsewhere, and which of them hold together.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "fusion/turntable/turntable_solver.h"

namespace scanknit {

/// Angles of all `sequences` from those of the ones that were tracked (growing both, at least two tracked). A frame
/// that was not lies between its neighbours, or, where these are not as far apart as is usual, before the first and
/// after the last of them, the usual step from the frame before: registration finds it from near by. One number a
/// sequence.
[[nodiscard]] std::vector<double> angles_of_all(const std::vector<std::uint64_t>& sequences,
                                                const std::vector<std::uint64_t>& tracked,
                                                const std::vector<double>& tracked_rad);

/// `start` with the angles that follow from pair to pair, those that are nearest in sequence first: where tracking was
/// wrong about a frame, a robust solver would take its good pairs for outliers. What no pair joins stays together where
/// it was.
[[nodiscard]] TurntableMotion along_pairs(const TurntableMotion& start, const std::vector<TurntableEdge>& edges);

/// The frames of a turn in parts: 0 for the largest, then as they come; pairs of frames join those of a part. A pair
/// of less than `least_weight` joins nothing. One number a frame.
[[nodiscard]] std::vector<std::size_t> turntable_parts(const TurntableSolution& solution,
                                                       const std::vector<TurntableEdge>& edges, double least_weight);

/// Pairs across places where the solution's turn goes backwards, by more than a degree, beside a frame that was not
/// tracked: what looks alike a quarter of a turn on fits there as well as the truth. One flag a pair, true: not to be
/// believed.
[[nodiscard]] std::vector<bool> backward_jumps(const TurntableMotion& motion, const std::vector<TurntableEdge>& edges,
                                               const std::vector<bool>& is_tracked);

/// Angles from elsewhere against those of the pictures alone.
struct PriorCheck {
  double scale = 1;                       ///< least squares of the pictures' turn by the known one, within the parts
  double typical_off_rad = 0;             ///< median of what is left without the scale
  bool contradicts = false;               ///< more than `tolerance_rad` for a fifth of the frames or more, or across
                                          ///< the widest part by its scale
  std::vector<std::size_t> off;           ///< frames that are, where they are fewer
  std::vector<double> agreed_angles_rad;  ///< the known ones, but those of the pictures for frames that are off; each
                                          ///< in the full turn that is nearest to the pictures
};

/// `parts` are those of turntable_parts(); between them the pictures hold nothing. A frame alone is not compared.
[[nodiscard]] PriorCheck check_prior(const std::vector<double>& known_rad, const TurntableMotion& seen,
                                     const std::vector<std::size_t>& parts, double tolerance_rad);

}  // namespace scanknit
