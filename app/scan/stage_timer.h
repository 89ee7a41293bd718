// Timing of stages.
#pragma once

#include <chrono>
#include <utility>

#include "export/report/report.h"

namespace scanknit {

/// Adds the time between its making and its end to `times`, as one sample.
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

/// Calls `work` and notes under `stage` how long it took.
template <typename Work>
auto timed(RunReport& report, const char* stage, Work&& work) {
  const StageTimer timer(report.stages[stage]);
  return std::forward<Work>(work)();
}

}  // namespace scanknit
