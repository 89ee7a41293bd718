#include "core/files/temporary_files.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <system_error>

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPattern = "XXXXXX";  // mkostemp's

/// Never destroyed: threads may outlive main().
struct Registry {
  std::mutex mutex;
  std::set<fs::path> paths;
};

Registry& registry() {
  static auto* const instance = new Registry;
  return *instance;
}

fs::path folder_of(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

/// Begins the names of all temporary files of the destination, and of no other file.
std::string prefix_of(const fs::path& destination) {
  return "." + destination.filename().string() + ".scanknit.";
}

/// True if a minute has passed since it was written last, and no process writes it.
bool is_abandoned(int descriptor) {
  constexpr std::time_t kMinute_s = 60;  // a new file is not yet locked
  struct stat status {};
  if (::fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) return false;
  return std::time(nullptr) - status.st_mtime > kMinute_s && ::flock(descriptor, LOCK_EX | LOCK_NB) == 0;
}

}  // namespace

Result<TemporaryFile> create_temporary_file(const fs::path& destination) {
  std::string path = (folder_of(destination) / (prefix_of(destination) + std::string(kPattern))).string();
  Registry& files = registry();
  const std::scoped_lock lock(files.mutex);  // so that remove_temporary_files() finds it
  const int descriptor = ::mkostemp(path.data(), O_CLOEXEC);
  if (descriptor < 0) {
    return Error{ErrorCode::kOutput, std::string("cannot be written: ") + std::strerror(errno), destination.string()};
  }
  (void)::flock(descriptor, LOCK_EX | LOCK_NB);  // where there are no locks, its age alone protects it
  files.paths.insert(path);
  return TemporaryFile{path, descriptor};
}

void forget_temporary_file(const fs::path& path) noexcept {
  Registry& files = registry();
  const std::scoped_lock lock(files.mutex);
  files.paths.erase(path);
}

void remove_temporary_files() noexcept {
  Registry& files = registry();
  const std::scoped_lock lock(files.mutex);
  for (const fs::path& path : files.paths) ::unlink(path.c_str());
}

void remove_abandoned_files(const fs::path& destination) noexcept try {
  const std::string prefix = prefix_of(destination);
  std::error_code code;
  for (fs::directory_iterator entry(folder_of(destination), code), end; !code && entry != end; entry.increment(code)) {
    const std::string name = entry->path().filename().string();
    if (name.size() != prefix.size() + kPattern.size() || !name.starts_with(prefix)) continue;
    const int descriptor = ::open(entry->path().c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
    if (descriptor < 0) continue;
    if (is_abandoned(descriptor)) ::unlink(entry->path().c_str());
    ::close(descriptor);
  }
} catch (const std::exception&) {  // out of memory: they stay until the next run
}

}  // namespace scanknit
