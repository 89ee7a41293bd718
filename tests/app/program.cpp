#include "tests/app/program.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <utility>

#include "tests/support/places.h"

namespace scanknit {
namespace {

void redirect(int descriptor, const std::filesystem::path& file) {
  const int opened = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  if (opened < 0 || ::dup2(opened, descriptor) < 0) ::_exit(127);
}

[[noreturn]] void become_scanknit(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
                                  std::optional<std::uintmax_t> max_file_bytes) {
  redirect(STDOUT_FILENO, folder / "out");
  redirect(STDERR_FILENO, folder / "err");
  if (max_file_bytes) {
    const rlimit limit{*max_file_bytes, *max_file_bytes};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  std::vector<char*> argv = {const_cast<char*>(test::kProgram.c_str())};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  ::execv(test::kProgram.c_str(), argv.data());
  ::_exit(127);
}

}  // namespace

TempFolder::TempFolder() {
  std::string pattern = (std::filesystem::path(::testing::TempDir()) / "scanknit_test.XXXXXX").string();
  path_ = ::mkdtemp(pattern.data());
}

TempFolder::~TempFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

Program::Program(const std::vector<std::string>& arguments, std::optional<std::uintmax_t> max_file_bytes) {
  std::array<int, 2> keys{};
  if (::pipe2(keys.data(), O_CLOEXEC) != 0) ADD_FAILURE() << "no pipe";
  process_ = ::fork();
  if (process_ == 0) {
    if (::dup2(keys[0], STDIN_FILENO) < 0) ::_exit(127);
    become_scanknit(arguments, folder_.path(), max_file_bytes);
  }
  ::close(keys[0]);
  keyboard_ = keys[1];
}

Program::~Program() {
  if (!is_running()) return;
  send(SIGKILL);
  (void)wait();
}

std::string Program::err_so_far() const {
  return read_text(folder_ / "err");
}

bool Program::is_running() {
  if (status_) return false;
  int status = 0;
  if (::waitpid(process_, &status, WNOHANG) == process_) status_ = status;
  return !status_;
}

void Program::send(int signal) const {
  ::kill(process_, signal);
}

void Program::type(const std::string& text) const {
  EXPECT_EQ(::write(keyboard_, text.data(), text.size()), static_cast<ssize_t>(text.size()));
}

Outcome Program::wait() {
  if (keyboard_ >= 0) ::close(std::exchange(keyboard_, -1));
  if (!status_) {
    int status = 0;
    ::waitpid(process_, &status, 0);
    status_ = status;
  }
  const int exit_code = WIFEXITED(*status_) ? WEXITSTATUS(*status_) : 128 + WTERMSIG(*status_);
  return {exit_code, read_text(folder_ / "out"), read_text(folder_ / "err")};
}

Outcome scanknit_command(const std::vector<std::string>& arguments, std::optional<std::uintmax_t> max_file_bytes) {
  return Program(arguments, max_file_bytes).wait();
}

std::string read_text(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace scanknit
