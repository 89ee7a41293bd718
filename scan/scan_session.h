// ScanSession: what all stages of one scan share: the observer, the stop token, the stage times, and the warnings.
#pragma once

#include <cstddef>
#include <set>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "scan/scan_job.h"
#include "scan/scan_observer.h"
#include "scan/scan_result.h"
#include "scan/stage_times.h"

namespace scanknit {

class ScanSession {
 public:
  /// `observer` outlives it.
  ScanSession(ScanObserver& observer, std::stop_token stop) : observer_(observer), stop_(std::move(stop)) {}
  ScanSession(const ScanSession&) = delete;
  ScanSession& operator=(const ScanSession&) = delete;

  [[nodiscard]] ScanObserver& observer() { return observer_; }
  [[nodiscard]] const std::stop_token& stop() const { return stop_; }
  [[nodiscard]] bool is_stopped() const { return stop_.stop_requested(); }

  void info(std::string_view text) { observer_.on_message(LogLevel::kInfo, text); }
  void debug(std::string_view text) { observer_.on_message(LogLevel::kDebug, text); }
  void progress(std::string_view what, std::size_t done, std::size_t total) {
    observer_.on_progress(what, done, total);
  }

  /// A warning that was given already is not given again.
  void warn(WarningCode code, std::string text);
  /// Tells the observer of a warning that belongs to one mesh, and returns it for MeshResult::warnings. If an earlier
  /// mesh had a warning of the same code and step, the observer is not told again. `step`: the word of a FinishStep,
  /// or empty.
  [[nodiscard]] ScanWarning warn_of_mesh(WarningCode code, std::string_view step, std::string text);

  /// Without those of meshes, in the order in which they came.
  [[nodiscard]] const std::vector<ScanWarning>& warnings() const { return warnings_; }

  /// Calls `work` and adds its duration to `stage`, and its memory.
  template <typename Work>
  auto timed(const char* stage, Work&& work) {
    const StageTimer timer(times_[stage]);
    return std::forward<Work>(work)();
  }
  /// For stages whose time is taken otherwise.
  [[nodiscard]] PeakMemoryWatch watch_memory(const char* stage) { return PeakMemoryWatch(times_[stage].peak_rss_mib); }
  void note_time(const char* stage, double milliseconds) { times_[stage].samples_ms.push_back(milliseconds); }
  [[nodiscard]] StageTimesByName& times() { return times_; }

  /// The result of the scan, completed with how it ended, its configuration, warnings, times and files, and with the
  /// job's input unless it names a scanner that was found.
  [[nodiscard]] ScanResult conclude(Result<void> outcome, const ScanJob& job, ScanResult result) const;

 private:
  ScanObserver& observer_;
  std::stop_token stop_;
  std::vector<ScanWarning> warnings_;
  std::set<std::pair<WarningCode, std::string>> reported_mesh_warnings_;  ///< code and step
  StageTimesByName times_;
};

}  // namespace scanknit
