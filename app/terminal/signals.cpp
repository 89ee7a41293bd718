#include "app/terminal/signals.h"

#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#include "app/exit_codes.h"
#include "core/files/temporary_files.h"

namespace scanknit {
namespace {

constexpr int kWakeUp = SIGUSR1;  // sent only to the waiting thread, to end it

/// True when SIGHUP is ignored, as nohup sets it.
bool outlives_terminal() {
  struct sigaction action {};
  return sigaction(SIGHUP, nullptr, &action) == 0 && action.sa_handler == SIG_IGN;
}

sigset_t signals_to_wait_for() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  if (!outlives_terminal()) sigaddset(&signals, SIGHUP);
  sigaddset(&signals, kWakeUp);
  return signals;
}

void wait_for_signals(std::stop_source source) {
  const sigset_t signals = signals_to_wait_for();
  for (int signal = 0; sigwait(&signals, &signal) == 0 && signal != kWakeUp;) {
    const bool is_first = source.request_stop();
    if (is_first || signal == SIGHUP) continue;
    // No incomplete file has its final name (core/files/atomic_file.h), so exiting here is safe.
    remove_temporary_files();
    ::_exit(kExitInterrupted);
  }
}

}  // namespace

StopOnSignal::StopOnSignal() {
  // Ctrl-C also ends a `tee` that reads our output: writing to the closed pipe must not kill the scan.
  ::signal(SIGPIPE, SIG_IGN);
  const sigset_t signals = signals_to_wait_for();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  waiter_ = std::jthread([source = source_] { wait_for_signals(source); });
}

StopOnSignal::~StopOnSignal() {
  pthread_kill(waiter_.native_handle(), kWakeUp);
}

}  // namespace scanknit
