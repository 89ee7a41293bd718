// How long each stage of a scan took.
#pragma once

#include <chrono>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace scanknit {

/// One sample for each time that a stage ran.
struct StageTimes {
  std::vector<double> samples_ms;
  [[nodiscard]] double total_ms() const;
  [[nodiscard]] double median_ms() const;  ///< 0 without samples
  [[nodiscard]] double p95_ms() const;     ///< nearest rank; 0 without samples
};

/// By the stage's name: acquire, filter, track, raycast, integrate, extract, export ... (docs/report.md).
using StageTimesByName = std::map<std::string, StageTimes>;

/// Adds the samples of `from` to those of `to`.
void add_times(const StageTimesByName& from, StageTimesByName& to);

/// Adds the time between its construction and its destruction to `times`, as one sample.
class StageTimer {
 public:
  explicit StageTimer(StageTimes& times) : times_(times) {}
  ~StageTimer() {
    const std::chrono::duration<double, std::milli> spent = std::chrono::steady_clock::now() - begin_;
    times_.samples_ms.push_back(spent.count());
  }
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  StageTimes& times_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace scanknit
