#include "measure/compare/deviation_stats.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>

namespace scanknit {
namespace {

double at_rank(const std::vector<double>& sorted, double percent) {
  const double place = std::ceil(percent / 100 * static_cast<double>(sorted.size())) - 1;
  return sorted[static_cast<std::size_t>(std::clamp(place, 0.0, static_cast<double>(sorted.size() - 1)))];
}

}  // namespace

DeviationStats deviation_stats(std::vector<double> distances_m) {
  DeviationStats stats;
  stats.count = distances_m.size();
  if (distances_m.empty()) return stats;
  const auto n = static_cast<double>(distances_m.size());
  double sum = 0, sum_of_sizes = 0, sum_of_squares = 0;
  for (const double d : distances_m) {
    sum += d;
    sum_of_sizes += std::abs(d);
    sum_of_squares += d * d;
  }
  stats.mean_m = sum / n;
  stats.mean_absolute_m = sum_of_sizes / n;
  stats.rms_m = std::sqrt(sum_of_squares / n);
  double sum_from_mean = 0;
  for (const double d : distances_m) sum_from_mean += (d - stats.mean_m) * (d - stats.mean_m);
  stats.deviation_m = std::sqrt(sum_from_mean / n);

  tbb::parallel_sort(distances_m.begin(), distances_m.end());
  stats.min_m = distances_m.front();
  stats.max_m = distances_m.back();
  for (std::size_t i = 0; i < kSignedPercentiles.size(); ++i) {
    stats.percentiles_m[i] = at_rank(distances_m, kSignedPercentiles[i]);
  }
  for (double& d : distances_m) d = std::abs(d);
  tbb::parallel_sort(distances_m.begin(), distances_m.end());
  stats.max_absolute_m = distances_m.back();
  for (std::size_t i = 0; i < kAbsolutePercentiles.size(); ++i) {
    stats.absolute_percentiles_m[i] = at_rank(distances_m, kAbsolutePercentiles[i]);
  }
  return stats;
}

double share_beyond(std::span<const double> distances_m, double tolerance_m) {
  if (distances_m.empty()) return 0;
  const auto beyond =
      std::count_if(distances_m.begin(), distances_m.end(), [&](double d) { return !(std::abs(d) <= tolerance_m); });
  return static_cast<double>(beyond) / static_cast<double>(distances_m.size());
}

DeviationHistogram deviation_histogram(std::span<const double> distances_m, double end_m) {
  DeviationHistogram histogram{end_m, std::vector<double>(kHistogramBins, 0.0)};
  if (distances_m.empty()) return histogram;
  const double each = 1 / static_cast<double>(distances_m.size());
  for (const double d : distances_m) {
    const double place = std::floor((d / end_m + 1) / 2 * kHistogramBins);
    if (d < -end_m) {
      histogram.share_below += each;
    } else if (!(d <= end_m)) {
      histogram.share_above += each;
    } else {
      histogram.shares[static_cast<std::size_t>(std::clamp(place, 0.0, kHistogramBins - 1.0))] += each;
    }
  }
  return histogram;
}

double scale_end_m(const DeviationStats& stats) {
  constexpr double kLeastM = 1e-6;
  const double most_m = std::max(stats.absolute_percentiles_m.back(), kLeastM);
  const double decade = std::pow(10.0, std::floor(std::log10(most_m)));
  constexpr double kRounding = 1 - 1e-9;  // pow() may be a little above or below
  for (const double step : {1.0, 2.0, 5.0}) {
    if (most_m * kRounding <= step * decade) return step * decade;
  }
  return 10 * decade;
}

}  // namespace scanknit
