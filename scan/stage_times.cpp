#include "scan/stage_times.h"

#include <algorithm>
#include <numeric>

namespace scanknit {

double StageTimes::total_ms() const {
  return std::accumulate(samples_ms.begin(), samples_ms.end(), 0.0);
}

double StageTimes::median_ms() const {
  if (samples_ms.empty()) return 0;
  std::vector<double> sorted = samples_ms;
  std::sort(sorted.begin(), sorted.end());
  const std::size_t half = sorted.size() / 2;
  return sorted.size() % 2 == 1 ? sorted[half] : (sorted[half - 1] + sorted[half]) / 2;
}

double StageTimes::p95_ms() const {
  if (samples_ms.empty()) return 0;
  std::vector<double> sorted = samples_ms;
  std::sort(sorted.begin(), sorted.end());
  const std::size_t rank = (95 * sorted.size() + 99) / 100;  // nearest rank, from 1: ceil(0.95 n)
  return sorted[rank - 1];
}

void add_times(const StageTimesByName& from, StageTimesByName& to) {
  for (const auto& [stage, times] : from) {
    auto& samples = to[stage].samples_ms;
    samples.insert(samples.end(), times.samples_ms.begin(), times.samples_ms.end());
    to[stage].peak_rss_mib = std::max(to[stage].peak_rss_mib, times.peak_rss_mib);
  }
}

}  // namespace scanknit
