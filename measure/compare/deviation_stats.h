// DeviationStats: what many signed distances amount to.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace scanknit {

/// Percentiles that DeviationStats gives.
inline constexpr std::array<double, 7> kSignedPercentiles = {1, 5, 25, 50, 75, 95, 99};
inline constexpr std::array<double, 4> kAbsolutePercentiles = {50, 90, 95, 99};

/// All zero if there are no distances. Percentiles are distances that occur, by the nearest rank.
struct DeviationStats {
  std::size_t count = 0;
  double mean_m = 0, deviation_m = 0;  ///< of the signed distances; their standard deviation
  double mean_absolute_m = 0, rms_m = 0;
  double min_m = 0, max_m = 0, max_absolute_m = 0;
  std::array<double, kSignedPercentiles.size()> percentiles_m = {};
  std::array<double, kAbsolutePercentiles.size()> absolute_percentiles_m = {};
};
[[nodiscard]] DeviationStats deviation_stats(std::vector<double> distances_m);

/// The share of distances whose size is above `tolerance_m`; 0 for none.
[[nodiscard]] double share_beyond(std::span<const double> distances_m, double tolerance_m);

/// Bins of equal width from -end_m to end_m; shares of all distances.
struct DeviationHistogram {
  double end_m = 0;
  std::vector<double> shares;
  double share_below = 0, share_above = 0;
};
inline constexpr std::size_t kHistogramBins = 41;  // odd: the one in the middle is of the points that agree
[[nodiscard]] DeviationHistogram deviation_histogram(std::span<const double> distances_m, double end_m);

/// 1, 2 or 5 times a power of ten, the smallest that is not below the 99th percentile of sizes; > 0.
[[nodiscard]] double scale_end_m(const DeviationStats& stats);

}  // namespace scanknit
