// LocalWorkers: processes of this program, on this machine, that work on one job.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"

namespace scanknit {

class LocalWorkers {
 public:
  /// How a worker ended: the exit code, or the signal that ended it.
  struct End {
    std::size_t worker = 0;  ///< from 1
    int code = 0;
    std::optional<int> signal;
  };

  /// Starts `count` times this program with these arguments, without a console. They stop when this process
  /// dies. Must be called by the thread that outlives them. Errors (kInternal): the system has no room for processes;
  /// those that began are ended.
  [[nodiscard]] static Result<LocalWorkers> start(std::size_t count, const std::vector<std::string>& arguments);

  LocalWorkers(LocalWorkers&&) = default;
  LocalWorkers& operator=(LocalWorkers&&) = delete;
  LocalWorkers(const LocalWorkers&) = delete;
  LocalWorkers& operator=(const LocalWorkers&) = delete;
  /// Ends those that are left, and waits for them.
  ~LocalWorkers();

  [[nodiscard]] bool are_running() const;
  /// SIGTERM to all that are running.
  void stop() const;
  /// Waits until there is something new, at most for `patience`. Returns what they said on stderr meanwhile, whole
  /// lines, each with "worker 2: " before it.
  [[nodiscard]] std::string wait(std::chrono::milliseconds patience);
  /// Of those that ended, in this order.
  [[nodiscard]] const std::vector<End>& ends() const { return ends_; }

 private:
  struct Worker {
    pid_t process = -1;      ///< -1: it has ended
    int messages = -1;       ///< reads its stderr; -1: at its end
    std::string unfinished;  ///< of a line
  };
  LocalWorkers() = default;
  [[nodiscard]] std::string read_messages(std::size_t number);
  void note_end(std::size_t number);

  std::vector<Worker> workers_;
  std::vector<End> ends_;
};

}  // namespace scanknit
