#include "app/cluster/run_program.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

namespace scanknit {
namespace {

/// Both ends of a pipe, which no other child inherits.
class Pipe {
 public:
  Pipe() { is_open_ = ::pipe2(ends_.data(), O_CLOEXEC) == 0; }
  ~Pipe() {
    close_writer();
    close_reader();
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;

  [[nodiscard]] bool is_open() const { return is_open_; }
  [[nodiscard]] int reader() const { return ends_[0]; }
  [[nodiscard]] int writer() const { return ends_[1]; }
  void close_writer() { close(ends_[1]); }
  void close_reader() { close(ends_[0]); }

  /// Appends what there is. False at the end.
  [[nodiscard]] bool read_into(std::string& text) const {
    std::array<char, 4096> bytes;
    const ssize_t count = ::read(reader(), bytes.data(), bytes.size());
    if (count < 0) return errno == EINTR;
    text.append(bytes.data(), static_cast<std::size_t>(count));
    return count > 0;
  }

 private:
  static void close(int& end) {
    if (end >= 0) ::close(std::exchange(end, -1));
  }
  std::array<int, 2> ends_ = {-1, -1};
  bool is_open_ = false;
};

/// Its streams, and no blocked signals. Returns the system's error number; 0 if it runs.
int spawn(pid_t& process, const std::vector<std::string>& words, const Pipe& out, const Pipe& err) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&files, out.writer(), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&files, err.writer(), STDERR_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  const int fault = ::posix_spawnp(&process, arguments[0], &files, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  return fault;
}

void read_both(Pipe& out, Pipe& err, ProgramEnd& end) {
  while (out.reader() >= 0 || err.reader() >= 0) {
    std::array<pollfd, 2> ends = {{{out.reader(), POLLIN, 0}, {err.reader(), POLLIN, 0}}};
    if (::poll(ends.data(), ends.size(), -1) < 0) continue;  // a signal
    if (ends[0].revents != 0 && !out.read_into(end.out)) out.close_reader();
    if (ends[1].revents != 0 && !err.read_into(end.err)) err.close_reader();
  }
}

}  // namespace

Result<ProgramEnd> run_program(const std::vector<std::string>& words) {
  const auto not_started = [&](int fault) {
    return Error{ErrorCode::kInternal, std::string("cannot be started: ") + std::strerror(fault), words[0]};
  };
  Pipe out, err;
  if (!out.is_open() || !err.is_open()) return not_started(errno);
  pid_t process = -1;
  if (const int fault = spawn(process, words, out, err); fault != 0) return not_started(fault);
  out.close_writer();
  err.close_writer();
  ProgramEnd end;
  read_both(out, err, end);
  int status = 0;
  while (::waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  end.code = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
  return end;
}

}  // namespace scanknit
