#include "app/cluster/cluster_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <span>
#include <system_error>

#include "core/files/atomic_file.h"
#include "core/files/crc32.h"
#include "core/files/read_file.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMaxText = 16 << 20;
constexpr std::size_t kShownLines = 5;

const char* word_of(ClusterStep step) {
  switch (step) {
    case ClusterStep::kPlan: return "plan";
    case ClusterStep::kWork: return "work";
    case ClusterStep::kJoin: return "join";
  }
  return "";
}

/// One word for a POSIX shell.
std::string quoted(const std::string& word) {
  std::string text = "'";
  for (const char letter : word) text += letter == '\'' ? "'\\''" : std::string(1, letter);
  return text + "'";
}

std::string last_lines(std::string text) {
  while (text.ends_with('\n')) text.pop_back();
  std::size_t begin = text.size();
  for (std::size_t lines = 0; lines < kShownLines && begin != 0 && begin != std::string::npos; ++lines) {
    begin = text.rfind('\n', begin - 1);
  }
  return begin == std::string::npos ? text : text.substr(begin == 0 ? 0 : begin + 1);
}

}  // namespace

FileLock::~FileLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

ClusterFolder::ClusterFolder(const fs::path& job) {
  std::error_code code;
  job_ = fs::weakly_canonical(fs::absolute(job), code);
  if (!job_.has_filename()) job_ = job_.parent_path();
  folder_ = job_.string() + ".slurm";
}

fs::path ClusterFolder::file(ClusterStep step, const std::string& ending) const {
  return folder_ / (std::string(word_of(step)) + ending);
}

std::string ClusterFolder::name_of(ClusterStep step) const {
  const std::string path = job_.string();
  return fmt::format("scanknit-{}-{:08x}", word_of(step), crc32(std::as_bytes(std::span(path))));
}

std::vector<std::string> ClusterFolder::names() const {
  std::vector<std::string> names;
  for (const ClusterStep step : kClusterSteps) names.push_back(name_of(step));
  return names;
}

std::string ClusterFolder::script(ClusterStep step, const std::vector<std::string>& arguments) const {
  std::error_code code;
  std::string command = quoted(fs::read_symlink("/proc/self/exe", code).string());
  for (const std::string& argument : arguments) command += " " + quoted(argument);
  return fmt::format("#!/bin/sh\ncd {} || exit 4\n{}\ncode=$?\necho $code >> {}\nexit $code\n",
                     quoted(fs::current_path(code).string()), command, quoted(file(step, ".ends").string()));
}

bool ClusterFolder::has_script(ClusterStep step, const std::vector<std::string>& arguments) const {
  const auto text = read_text_file(file(step, ".sh"), kMaxText);
  return text && *text == script(step, arguments);
}

bool ClusterFolder::has_script(ClusterStep step) const {
  std::error_code code;
  return fs::exists(file(step, ".sh"), code);
}

std::vector<fs::path> ClusterFolder::files_of(ClusterStep step) const {
  std::vector<fs::path> files;
  std::error_code code;
  const std::string word = word_of(step);
  for (const auto& entry : fs::directory_iterator(folder_, code)) {
    const std::string name = entry.path().filename();
    if (name.starts_with(word + ".") || name.starts_with(word + "-")) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

Result<SlurmBatch> ClusterFolder::prepare(ClusterStep step, const std::vector<std::string>& arguments) const {
  std::error_code code;
  for (const fs::path& old : files_of(step)) fs::remove(old, code);
  const fs::path path = file(step, ".sh");
  if (const auto written = write_file_atomically(path, script(step, arguments)); !written) return written.error();
  const std::string task = step == ClusterStep::kWork ? "-%a" : "";
  return SlurmBatch{
      .name = name_of(step), .script = path, .out = file(step, task + ".out"), .err = file(step, task + ".err")};
}

std::vector<int> ClusterFolder::ends_of(ClusterStep step) const {
  std::vector<int> codes;
  std::ifstream ends(file(step, ".ends"));
  for (int code = 0; ends >> code;) codes.push_back(code);
  return codes;
}

Result<std::string> ClusterFolder::printed_by(ClusterStep step) const {
  std::error_code code;
  if (!fs::exists(file(step, ".out"), code)) return std::string();
  return read_text_file(file(step, ".out"), kMaxText);
}

std::string ClusterFolder::errors_of(ClusterStep step) const {
  for (const fs::path& path : files_of(step)) {
    if (path.extension() != ".err") continue;
    if (const auto text = read_text_file(path, kMaxText); text && !text->empty()) return last_lines(*text);
  }
  return "";
}

Result<FileLock> ClusterFolder::lock() const {
  std::error_code code;
  fs::create_directories(folder_, code);
  if (code) return Error{ErrorCode::kOutput, "cannot be made: " + code.message(), folder_.string()};
  const fs::path path = folder_ / "lock";
  const int descriptor = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor < 0)
    return Error{ErrorCode::kOutput, std::string("cannot be made: ") + std::strerror(errno), path.string()};
  while (::flock(descriptor, LOCK_EX) != 0 && errno == EINTR) {
  }
  return FileLock(descriptor);
}

bool ClusterFolder::is_cancelled() const {
  std::error_code code;
  return fs::exists(folder_ / "cancelled", code);
}

Result<void> ClusterFolder::set_cancelled(bool is_cancelled) const {
  const fs::path path = folder_ / "cancelled";
  if (is_cancelled) return write_file_atomically(path, "");
  std::error_code code;
  fs::remove(path, code);
  if (code) return Error{ErrorCode::kOutput, "cannot be removed: " + code.message(), path.string()};
  return {};
}

}  // namespace scanknit
