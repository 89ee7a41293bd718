// Compares known angles of a turntable with those from the pictures, and finds the parts of the turn that are joined.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "fusion/turntable/turntable_solver.h"

namespace scanknit {

/// The angles of all `sequences` from those of the tracked ones (both ascending, at least two tracked). Interpolates a
/// frame that was not tracked between its neighbours; if their distance is unusual, and before the first and after the
/// last tracked frame, adds the usual step to the frame before: registration finds the exact angle from there. One
/// number for each sequence.
[[nodiscard]] std::vector<double> angles_of_all(const std::vector<std::uint64_t>& sequences,
                                                const std::vector<std::uint64_t>& tracked,
                                                const std::vector<double>& tracked_rad);

/// Returns `start` with angles accumulated from pair to pair, the pairs nearest in sequence first. This is needed where
/// tracking was wrong about a frame: a robust solver would take that frame's good pairs for outliers. Frames that no
/// pair joins keep their angles relative to each other.
[[nodiscard]] TurntableMotion along_pairs(const TurntableMotion& start, const std::vector<TurntableEdge>& edges);

/// Divides the frames into parts that are joined by pairs: 0 is the largest part, the others follow in order. Ignores
/// pairs with less than `least_weight`. One number for each frame.
[[nodiscard]] std::vector<std::size_t> turntable_parts(const TurntableSolution& solution,
                                                       const std::vector<TurntableEdge>& edges, double least_weight);

/// Marks pairs across places where the solution turns backwards by more than a degree next to a frame that was not
/// tracked. There, a side that looks the same a quarter of a turn on fits as well as the true one. One flag for each
/// pair; true: reject it.
[[nodiscard]] std::vector<bool> backward_jumps(const TurntableMotion& motion, const std::vector<TurntableEdge>& edges,
                                               const std::vector<bool>& is_tracked);

/// Known angles compared with those from the pictures.
struct PriorCheck {
  double scale = 1;                       ///< pictures' turn / known turn, by least squares within the parts
  double typical_off_rad = 0;             ///< median difference, without the scale
  bool contradicts = false;               ///< more than `tolerance_rad` for a fifth of the frames or more, or across
                                          ///< the widest part by its scale
  std::vector<std::size_t> off;           ///< frames that are, where they are fewer
  std::vector<double> agreed_angles_rad;  ///< the known ones, but those of the pictures for frames that are off; each
                                          ///< in the full turn that is nearest to the pictures
};

/// `parts`: from turntable_parts(). Compares only within a part, since the pictures do not connect parts; ignores parts
/// of one frame.
[[nodiscard]] PriorCheck check_prior(const std::vector<double>& known_rad, const TurntableMotion& seen,
                                     const std::vector<std::size_t>& parts, double tolerance_rad);

}  // namespace scanknit
