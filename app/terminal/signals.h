// Ctrl-C as a stop request.
#pragma once

#include <stop_token>
#include <thread>

namespace scanknit {

/// During its lifetime, the first SIGINT or SIGTERM is a stop request, and the second one ends the process at once with
/// exit code 130. A closed terminal (SIGHUP, which both the shell and the kernel send) is only a stop request, however
/// often it comes; under nohup it is ignored. Construct it before any other thread: later threads inherit the blocked
/// signals, so that only its own thread receives them. It needs no signal handler and no global. A closed pipe
/// (SIGPIPE) does not end the program.
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
