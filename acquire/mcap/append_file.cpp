#include "acquire/mcap/append_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "acquire/new_recording.h"

namespace scanknit {

Result<AppendFile> AppendFile::create(const std::filesystem::path& path) {
  if (auto is_new = check_is_new_recording(path, "give another name, or remove it"); !is_new) return is_new.error();
  std::error_code code;
  if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), code);
  if (code) return Error{ErrorCode::kOutput, "its folder cannot be made: " + code.message(), path.string()};
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
  if (descriptor >= 0) {
    (void)::flock(descriptor, LOCK_EX | LOCK_NB);  // for is_being_appended; not every file system has locks
    return AppendFile(path, descriptor);
  }
  return Error{ErrorCode::kOutput, std::string("cannot be written: ") + std::strerror(errno), path.string()};
}

AppendFile::AppendFile(AppendFile&& other) noexcept
    : path_(std::move(other.path_)), descriptor_(std::exchange(other.descriptor_, -1)), size_(other.size_) {}

AppendFile::~AppendFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Result<void> AppendFile::append(std::span<const std::byte> bytes) {
  std::span<const std::byte> rest = bytes;
  while (!rest.empty()) {
    const ssize_t written = ::write(descriptor_, rest.data(), rest.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      const int reason = written < 0 ? errno : EIO;
      const auto whole = static_cast<off_t>(size_);
      // When even this fails, readers find the last whole piece by its checksum.
      if (::ftruncate(descriptor_, whole) == 0) (void)::lseek(descriptor_, whole, SEEK_SET);
      return Error{ErrorCode::kOutput, std::string("writing failed: ") + std::strerror(reason), path_.string()};
    }
    rest = rest.subspan(static_cast<std::size_t>(written));
  }
  size_ += bytes.size();
  return {};
}

Result<void> AppendFile::sync() const {
  if (::fdatasync(descriptor_) == 0) return {};
  return Error{ErrorCode::kOutput, std::string("writing to the disk failed: ") + std::strerror(errno), path_.string()};
}

bool AppendFile::is_in_place() const {
  struct stat ours = {};
  struct stat there = {};
  return ::fstat(descriptor_, &ours) == 0 && ::stat(path_.c_str(), &there) == 0 && ours.st_dev == there.st_dev &&
         ours.st_ino == there.st_ino;
}

void AppendFile::remove() const {
  if (is_in_place()) ::unlink(path_.c_str());
}

bool is_being_appended(const std::filesystem::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) return false;
  const bool is_locked = ::flock(descriptor, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  ::close(descriptor);
  return is_locked;
}

}  // namespace scanknit
