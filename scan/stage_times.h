// StageTimer: takes the time of each stage of a scan, and watches its memory.
#pragma once

#include <chrono>

#include "core/system/peak_memory.h"
#include "scan/scan_result.h"

namespace scanknit {

/// Adds the samples of `from` to those of `to`; the larger peaks remain.
void add_times(const StageTimesByName& from, StageTimesByName& to);

/// Adds the time between its construction and its destruction to `times`, as one sample, and raises the peak to that of
/// this time.
class StageTimer {
 public:
  explicit StageTimer(StageTimes& times) : times_(times), memory_(times.peak_rss_mib) {}
  ~StageTimer() {
    const std::chrono::duration<double, std::milli> spent = std::chrono::steady_clock::now() - begin_;
    times_.samples_ms.push_back(spent.count());
  }
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  StageTimes& times_;
  PeakMemoryWatch memory_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace scanknit
