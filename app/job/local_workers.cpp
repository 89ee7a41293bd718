#include "app/job/local_workers.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

namespace scanknit {
namespace {

constexpr const char* kThisProgram = "/proc/self/exe";
constexpr int kNotStarted = 127;  // as shells have it

/// In the child: only what is safe between fork and exec in a process with threads.
[[noreturn]] void become_worker(char* const* arguments, int messages, pid_t parent) {
  // It comes once for each of the parent's threads, and a second SIGTERM would end the worker at once.
  (void)::signal(SIGHUP, SIG_DFL);
  (void)::prctl(PR_SET_PDEATHSIG, SIGHUP);
  (void)::setpgid(0, 0);  // Ctrl-C is the parent's, which passes it on
  sigset_t none;
  sigemptyset(&none);
  (void)::sigprocmask(SIG_SETMASK, &none, nullptr);
  const int nothing = ::open("/dev/null", O_RDWR);
  const bool is_ready = nothing >= 0 && ::dup2(nothing, STDIN_FILENO) >= 0 && ::dup2(nothing, STDOUT_FILENO) >= 0 &&
                        ::dup2(messages, STDERR_FILENO) >= 0;
  if (is_ready && ::getppid() == parent) ::execv(kThisProgram, arguments);
  ::_exit(kNotStarted);
}

Error not_started(const char* what) {
  return {ErrorCode::kInternal, std::string("a worker cannot be started: ") + what};
}

}  // namespace

Result<LocalWorkers> LocalWorkers::start(std::size_t count, const std::vector<std::string>& arguments) {
  std::vector<std::string> words = {"scanknit"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  const pid_t parent = ::getpid();
  LocalWorkers local;
  for (std::size_t i = 0; i < count; ++i) {
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) return not_started(std::strerror(errno));
    const pid_t process = ::fork();
    if (process == 0) become_worker(pointers.data(), ends[1], parent);
    const int fault = errno;
    ::close(ends[1]);
    if (process < 0) {
      ::close(ends[0]);
      return not_started(std::strerror(fault));
    }
    (void)::fcntl(ends[0], F_SETFL, O_NONBLOCK);
    local.workers_.push_back({process, ends[0], {}});
  }
  return local;
}

LocalWorkers::~LocalWorkers() {
  stop();
  for (const Worker& worker : workers_) {
    if (worker.process > 0) (void)::waitpid(worker.process, nullptr, 0);
    if (worker.messages >= 0) ::close(worker.messages);
  }
}

bool LocalWorkers::are_running() const {
  return ends_.size() < workers_.size();
}

void LocalWorkers::stop() const {
  for (const Worker& worker : workers_) {
    if (worker.process > 0) ::kill(worker.process, SIGTERM);
  }
}

std::string LocalWorkers::wait(std::chrono::milliseconds patience) {
  std::vector<pollfd> open;
  for (const Worker& worker : workers_) {
    if (worker.messages >= 0) open.push_back({worker.messages, POLLIN, 0});
  }
  (void)::poll(open.data(), open.size(), static_cast<int>(patience.count()));
  std::string said;
  for (std::size_t i = 0; i < workers_.size(); ++i) {
    if (workers_[i].messages >= 0) said += read_messages(i);
    if (workers_[i].messages < 0 && workers_[i].process > 0) note_end(i);
  }
  return said;
}

/// At the end of the pipe the worker has ended, or is about to.
std::string LocalWorkers::read_messages(std::size_t number) {
  Worker& worker = workers_[number];
  std::array<char, 4096> bytes;
  ssize_t count = 0;
  while ((count = ::read(worker.messages, bytes.data(), bytes.size())) > 0) {
    worker.unfinished.append(bytes.data(), static_cast<std::size_t>(count));
  }
  const bool is_at_end = count == 0 || (errno != EAGAIN && errno != EINTR);
  if (is_at_end) {
    ::close(std::exchange(worker.messages, -1));
    if (!worker.unfinished.empty() && !worker.unfinished.ends_with('\n')) worker.unfinished += '\n';
  }
  std::string said;
  for (std::size_t end = 0; (end = worker.unfinished.find('\n')) != std::string::npos;) {
    said += "worker " + std::to_string(number + 1) + ": " + worker.unfinished.substr(0, end + 1);
    worker.unfinished.erase(0, end + 1);
  }
  return said;
}

void LocalWorkers::note_end(std::size_t number) {
  Worker& worker = workers_[number];
  int status = 0;
  pid_t ended = 0;
  while ((ended = ::waitpid(worker.process, &status, 0)) < 0 && errno == EINTR) {
  }
  worker.process = -1;
  End end{number + 1, kNotStarted, std::nullopt};
  if (ended > 0 && WIFEXITED(status)) end.code = WEXITSTATUS(status);
  if (ended > 0 && WIFSIGNALED(status)) end.signal = WTERMSIG(status);
  ends_.push_back(end);
}

}  // namespace scanknit
