// Absolute trajectory error, as the TUM RGB-D benchmark defines it.
#pragma once

#include <cstddef>
#include <filesystem>

namespace scanknit {

struct TrajectoryError {
  std::size_t pairs = 0;      ///< stamps that both trajectories have, within `kSameStamp_s`
  std::size_t estimated = 0;  ///< poses of the estimate
  double rmse_m = 0;          ///< of the positions, after the best rigid alignment (Horn 1987), without scale
  double max_m = 0;
  double unaligned_rmse_m = 0;  ///< in the worlds as they are
};

inline constexpr double kSameStamp_s = 0.02;  // as evaluate_ate.py (Sturm et al. 2012)

/// Compares two files of the TUM format ("stamp tx ty tz qx qy qz qw", # for comments). No pairs: all zero.
[[nodiscard]] TrajectoryError trajectory_error(const std::filesystem::path& estimate,
                                               const std::filesystem::path& truth);

}  // namespace scanknit
