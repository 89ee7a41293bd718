#include "core/system/try_in_child.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <exception>
#include <fstream>
#include <new>
#include <optional>
#include <sstream>
#include <string>
#include <utility>

namespace scanknit {
namespace {

constexpr const char* kTooMuchMemory = "it would take more memory than a sound file of its size";

/// A pipe's end, closed when it goes.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() { close(); }
  void close() {
    if (number_ >= 0) ::close(std::exchange(number_, -1));
  }
  [[nodiscard]] int number() const { return number_; }

 private:
  int number_;
};

/// Bytes of address space that this process has; 0 if the system does not say.
std::size_t address_space_bytes() {
  std::FILE* file = std::fopen("/proc/self/statm", "re");
  if (file == nullptr) return 0;
  unsigned long long pages = 0;
  const int read = std::fscanf(file, "%llu", &pages);
  std::fclose(file);
  return read == 1 ? static_cast<std::size_t>(pages) * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE)) : 0;
}

void lower_limit(int resource, rlim_t value) {
  rlimit limit{};
  if (::getrlimit(static_cast<__rlimit_resource>(resource), &limit) != 0) return;
  limit.rlim_cur = std::min(limit.rlim_cur, value);
  ::setrlimit(static_cast<__rlimit_resource>(resource), &limit);
}

void apply(const ChildLimits& limits) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // never left behind
  lower_limit(RLIMIT_CORE, 0);
  lower_limit(RLIMIT_AS, address_space_bytes() + limits.memory_bytes);
  lower_limit(RLIMIT_CPU, static_cast<rlim_t>(std::ceil(limits.seconds)));
  for (const int signal : {SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGSEGV, SIGXCPU}) ::signal(signal, SIG_DFL);
}

/// The error of `work`: its code as one byte, then its message; nothing after success.
std::string answer_of(const std::function<Result<void>()>& work) {
  const auto answer = [](ErrorCode code, const std::string& message) { return static_cast<char>(code) + message; };
  try {
    const Result<void> done = work();
    return done ? "" : answer(done.error().code, done.error().message);
  } catch (const std::bad_alloc&) {
    return answer(ErrorCode::kInput, kTooMuchMemory);
  } catch (const std::exception& e) {
    return answer(ErrorCode::kInput, e.what());
  }
}

[[noreturn]] void be_child(const std::function<Result<void>()>& work, const ChildLimits& limits, int answer_to) {
  apply(limits);
  const std::string answer = answer_of(work);
  const bool is_written = ::write(answer_to, answer.data(), answer.size()) == static_cast<ssize_t>(answer.size());
  ::_exit(is_written ? 0 : 1);
}

/// What changes while a process works: its state, and its processor time and page faults; empty if the system does not
/// say. "S" is asleep, and not for a disk.
struct Progress {
  char state = '?';
  std::string work;
  friend bool operator==(const Progress&, const Progress&) = default;
};

Progress progress_of(pid_t process) {
  Progress progress;
  std::ifstream file("/proc/" + std::to_string(process) + "/stat");
  std::string text;
  std::getline(file, text);
  const std::size_t after_name = text.rfind(')');  // proc(5): the name before it may hold anything
  if (after_name == std::string::npos) return progress;
  std::istringstream fields(text.substr(after_name + 1));
  std::string field;
  fields >> progress.state;
  for (int number = 4; number <= 15 && fields >> field; ++number) {
    if (number >= 10) progress.work += field + " ";  // minflt to stime
  }
  return progress;
}

/// Waits until the child writes or ends; false: it slept for so long without any progress.
bool wait_for_answer(int descriptor, pid_t child, double stall_seconds) {
  constexpr int kSteps = 10;
  const int step_ms = std::max(1, static_cast<int>(1000 * stall_seconds / kSteps));
  Progress before = progress_of(child);
  for (int asleep = 0; asleep < kSteps;) {
    pollfd answer{descriptor, POLLIN, 0};
    const int ready = ::poll(&answer, 1, step_ms);
    if (ready > 0 || (ready < 0 && errno != EINTR)) return true;
    const Progress now = progress_of(child);
    asleep = now.state == 'S' && now == before ? asleep + 1 : 0;
    before = now;
  }
  return false;
}

std::string read_all(int descriptor) {
  std::string text;
  char part[512];
  for (;;) {
    const ssize_t count = ::read(descriptor, part, sizeof(part));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return text;
    text.append(part, static_cast<std::size_t>(count));
  }
}

/// Waits for the child; why it ended, if not by itself.
Result<void> wait_for(pid_t child) {
  int status = 0;
  while (::waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) return Error{ErrorCode::kInternal, std::string("waitpid: ") + std::strerror(errno)};
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
  if (WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL)) {
    return Error{ErrorCode::kInput, "reading it takes far too long, or far too much memory, for a file of its size"};
  }
  return Error{ErrorCode::kInput,
               "it is damaged in a way that crashes its reader, or the system has no memory or thread left"};
}

/// Nothing: the child stalled.
std::optional<Result<void>> try_once(const std::function<Result<void>()>& work, const ChildLimits& limits) {
  int ends[2] = {-1, -1};
  if (::pipe2(ends, O_CLOEXEC) != 0) {
    return Error{ErrorCode::kBudget, std::string("no pipe to a child process: ") + std::strerror(errno)};
  }
  const Descriptor answer(ends[0]);
  Descriptor answer_to(ends[1]);
  const pid_t child = ::fork();
  if (child < 0) return Error{ErrorCode::kBudget, std::string("no child process: ") + std::strerror(errno)};
  if (child == 0) be_child(work, limits, answer_to.number());
  answer_to.close();
  if (!wait_for_answer(answer.number(), child, limits.stall_seconds)) {
    ::kill(child, SIGKILL);
    (void)wait_for(child);
    return std::nullopt;
  }
  const std::string text = read_all(answer.number());
  if (auto ended = wait_for(child); !ended) return ended;
  if (text.empty()) return Result<void>();
  return Error{static_cast<ErrorCode>(text[0]), text.substr(1)};
}

}  // namespace

Result<void> try_in_child(const std::function<Result<void>()>& work, const ChildLimits& limits) {
  constexpr int kTries = 3;
  for (int i = 0; i < kTries; ++i) {
    if (auto result = try_once(work, limits)) return *result;
  }
  return Error{ErrorCode::kBudget, "a child process that reads it first does not come to its end; try again"};
}

}  // namespace scanknit
