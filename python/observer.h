// PythonObserver: tells Python's callables of a scan, and asks one of them for commands.
#pragma once

#include <pybind11/pybind11.h>

#include <chrono>
#include <exception>
#include <optional>
#include <stop_token>
#include <string_view>
#include <utility>

#include "scan/scan_observer.h"

namespace scanknit {

/// What Python wants to be called; null: not at all. docs/packages.md says with what.
struct Callbacks {
  pybind11::function progress = {}, warning = {}, frame = {}, command = {}, answer = {};
};

/// Python runs in the thread that scans, which does not hold the interpreter otherwise.
class PythonObserver final : public ScanObserver {
 public:
  explicit PythonObserver(Callbacks callbacks) : callbacks_(std::move(callbacks)) {}

  void on_progress(std::string_view what, std::size_t done, std::size_t total) override;
  void on_warning(const ScanWarning& warning) override;
  void on_frame(const Frame& frame, const std::optional<Pose>& T_world_camera, const ScanState& scan) override;
  [[nodiscard]] std::optional<ScanCommand> next_command(std::stop_token stop,
                                                        std::chrono::nanoseconds patience) override;
  void on_answer(const ScanCommand& command, const Result<void>& outcome, const FilesByKind& files,
                 const ScanState& scan) override;

  /// Requested when `progress` returns False, when a callable raises, and by Ctrl-C.
  [[nodiscard]] std::stop_token stop() const { return stop_.get_token(); }

  /// Raises what a callable raised, or KeyboardInterrupt. Needs the interpreter.
  void rethrow() const {
    if (raised_) std::rethrow_exception(raised_);
  }

 private:
  template <typename Call>
  void call(const Call& python_call);

  Callbacks callbacks_;
  bool has_commanded_ = false;  ///< the last call of next_command() gave a command
  std::stop_source stop_;
  std::exception_ptr raised_;
};

}  // namespace scanknit
