#include "core/files/part_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kFolderPattern = "XXXXXX";  // mkdtemp's

fs::path parent_of(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

std::string folder_prefix_of(const fs::path& beside) {
  return "." + beside.filename().string() + ".scanknit-bricks.";
}

/// -1: it is no folder, or has gone.
int open_folder(const fs::path& path) {
  return ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC | O_NOFOLLOW);
}

Error not_made(const fs::path& path) {
  return {ErrorCode::kOutput, std::string("cannot be made: ") + std::strerror(errno), path.string()};
}

/// True if no process has locked it, and it is a minute old: a new one is not yet locked.
bool is_left_over(int descriptor) {
  constexpr std::time_t kMinute_s = 60;
  struct stat status {};
  if (::fstat(descriptor, &status) != 0) return false;
  return std::time(nullptr) - status.st_mtime > kMinute_s && ::flock(descriptor, LOCK_EX | LOCK_NB) == 0;
}

void remove_left_over(const fs::path& beside) {
  const std::string prefix = folder_prefix_of(beside);
  std::vector<fs::path> found;
  std::error_code code;
  for (fs::directory_iterator entry(parent_of(beside), code), end; !code && entry != end; entry.increment(code)) {
    const std::string name = entry->path().filename().string();
    if (name.size() == prefix.size() + kFolderPattern.size() && name.starts_with(prefix))
      found.push_back(entry->path());
  }
  for (const fs::path& path : found) {
    const int descriptor = open_folder(path);
    if (descriptor < 0) continue;
    if (is_left_over(descriptor)) fs::remove_all(path, code);
    ::close(descriptor);
  }
}

}  // namespace

Result<PartFolder> PartFolder::create(const fs::path& beside) {
  remove_left_over(beside);
  std::error_code code;
  fs::create_directories(parent_of(beside), code);
  std::string path = (parent_of(beside) / (folder_prefix_of(beside) + std::string(kFolderPattern))).string();
  if (::mkdtemp(path.data()) == nullptr) {
    return Error{ErrorCode::kOutput, std::string("a folder cannot be made beside it: ") + std::strerror(errno),
                 beside.string()};
  }
  const int descriptor = open_folder(path);
  if (descriptor >= 0) (void)::flock(descriptor, LOCK_EX | LOCK_NB);  // where there are no locks, its age protects it
  return PartFolder(path, descriptor);
}

bool PartFolder::make_ready() const {
  const mode_t mask = ::umask(0);
  ::umask(mask);
  const int descriptor = open_folder(path_);
  const bool is_on_disk = descriptor >= 0 && ::fsync(descriptor) == 0;
  if (descriptor >= 0) ::close(descriptor);
  return is_on_disk && ::chmod(path_.c_str(), 0777 & ~mask) == 0;
}

Result<void> PartFolder::replace(const fs::path& path) {
  if (!fs::is_directory(fs::symlink_status(path))) return keep_as(path);
  if (!make_ready()) return not_made(path);
  if (::renameat2(AT_FDCWD, path_.c_str(), AT_FDCWD, path.c_str(), RENAME_EXCHANGE) == 0) return {};
  if (errno != EINVAL && errno != ENOSYS) return not_made(path);
  auto aside = create(path);  // the file system cannot exchange names
  if (!aside) return aside.error();
  const fs::path old = aside->path() / "old";
  if (::rename(path.c_str(), old.c_str()) != 0) return not_made(path);
  auto kept = keep_as(path);
  if (!kept) (void)::rename(old.c_str(), path.c_str());
  return kept;
}

Result<void> PartFolder::keep_as(const fs::path& path) {
  if (!make_ready() || ::rename(path_.c_str(), path.c_str()) != 0) return not_made(path);
  path_.clear();
  if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
  return {};
}

PartFolder::~PartFolder() {
  if (path_.empty()) return;
  std::error_code code;
  fs::remove_all(path_, code);
  if (descriptor_ >= 0) ::close(descriptor_);
}

}  // namespace scanknit
