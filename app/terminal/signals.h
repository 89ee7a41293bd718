// Ctrl-C as a stop request.
#pragma once

#include <stop_token>
#include <thread>

namespace scanknit {

/// While it lives, the first SIGINT or SIGTERM is a stop request and the second ends the process at once with exit code
/// 130. A closed terminal is a stop request, too, however often it says so (SIGHUP: the shell and the kernel both do),
/// unless the program was started to outlive it (nohup). Make it before any other thread: threads started later inherit
/// the blocked signals, so that only its own thread takes them. No signal handler and no global is needed. A pipe that
/// nobody reads any more is no reason to end.
class StopOnSignal {
 public:
  StopOnSignal();
  ~StopOnSignal();
  StopOnSignal(const StopOnSignal&) = delete;
  StopOnSignal& operator=(const StopOnSignal&) = delete;

  [[nodiscard]] std::stop_token token() const { return source_.get_token(); }

 private:
  std::stop_source source_;
  std::jthread waiter_;
};

}  // namespace scanknit
