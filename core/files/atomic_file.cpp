#include "core/files/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <utility>
#include <vector>

#include "core/files/temporary_files.h"

namespace scanknit {
namespace {

constexpr std::size_t kBufferBytes = 1u << 20;  // one system call per mebibyte

std::filesystem::path folder_of(const std::filesystem::path& file) {
  return file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
}

/// Write all of `bytes`, resuming after short writes and interruptions. Returns 0 or an errno.
int write_all(int descriptor, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    if (written == 0) return EIO;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return 0;
}

int sync_folder(const std::filesystem::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return errno;
  const int status = ::fsync(descriptor) == 0 ? 0 : errno;
  ::close(descriptor);
  return status == EINVAL ? 0
                          : status;  // some file systems cannot sync a folder; the rename is then as safe as it gets
}

mode_t file_mode() {
  const mode_t mask = ::umask(0);
  ::umask(mask);
  return 0644 & ~mask;
}

Error output_error(const std::filesystem::path& where, std::string_view what, int error_number) {
  return {ErrorCode::kOutput, std::string(what) + ": " + std::strerror(error_number), where.string()};
}

}  // namespace

Result<AtomicFile> AtomicFile::create(const std::filesystem::path& destination) {
  const std::filesystem::path folder = folder_of(destination);
  std::error_code code;
  if (std::filesystem::is_directory(destination, code)) {
    return Error{ErrorCode::kOutput, "cannot be written: it is a folder", destination.string()};
  }
  std::filesystem::create_directories(folder, code);
  if (code) return Error{ErrorCode::kOutput, "its folder cannot be made: " + code.message(), destination.string()};

  auto temporary = create_temporary_file(destination);
  if (!temporary) return temporary.error();
  AtomicFile file(destination, temporary->path, temporary->descriptor);
  if (::fchmod(temporary->descriptor, file_mode()) != 0) return file.failure("cannot set its permissions", errno);
  return file;
}

AtomicFile::AtomicFile(std::filesystem::path destination, std::filesystem::path temporary, int descriptor)
    : destination_(std::move(destination)), temporary_(std::move(temporary)), descriptor_(descriptor) {}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : destination_(std::move(other.destination_)),
      temporary_(std::exchange(other.temporary_, {})),
      descriptor_(std::exchange(other.descriptor_, -1)),
      buffer_(std::move(other.buffer_)) {}

AtomicFile& AtomicFile::operator=(AtomicFile&& other) noexcept {
  if (this == &other) return *this;
  discard();
  destination_ = std::move(other.destination_);
  temporary_ = std::exchange(other.temporary_, {});
  descriptor_ = std::exchange(other.descriptor_, -1);
  buffer_ = std::move(other.buffer_);
  return *this;
}

AtomicFile::~AtomicFile() {
  discard();
}

void AtomicFile::discard() noexcept {
  if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
  if (temporary_.empty()) return;
  ::unlink(temporary_.c_str());
  forget_temporary_file(std::exchange(temporary_, {}));
}

Error AtomicFile::failure(std::string_view what, int error_number) const {
  return output_error(destination_, what, error_number);
}

Result<void> AtomicFile::write(std::string_view text) {
  if (text.size() < kBufferBytes) {
    buffer_.append(text);
    return buffer_.size() >= kBufferBytes ? flush() : Result<void>{};
  }
  if (auto flushed = flush(); !flushed) return flushed;
  const int status = write_all(descriptor_, text);  // not copied first: it may be most of the memory there is
  return status == 0 ? Result<void>{} : failure("writing failed", status);
}

Result<void> AtomicFile::write(std::span<const std::byte> bytes) {
  return write(std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

Result<void> AtomicFile::flush() {
  SCANKNIT_CHECK(descriptor_ >= 0);
  const int status = write_all(descriptor_, buffer_);
  buffer_.clear();
  if (status != 0) return failure("writing failed", status);
  return {};
}

Result<void> AtomicFile::commit() {
  if (auto flushed = flush(); !flushed) return flushed;
  // A library may have replaced the file at temporary_path(): sync what has that name now.
  const int current = ::open(temporary_.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
  if (current < 0) return failure("the temporary file is gone", errno);
  const int synced = ::fsync(current) == 0 && ::fsync(descriptor_) == 0 ? 0 : errno;
  ::close(current);
  if (synced != 0) return failure("writing to the disk failed", synced);
  if (auto renamed = commit_without_sync(); !renamed) return renamed;
  const int folder_synced = sync_folder(folder_of(destination_));
  if (folder_synced != 0) return failure("its folder cannot be synced", folder_synced);
  return {};
}

Result<void> AtomicFile::commit_without_sync() {
  if (auto flushed = flush(); !flushed) return flushed;
  if (::close(std::exchange(descriptor_, -1)) != 0) return failure("closing failed", errno);
  if (::rename(temporary_.c_str(), destination_.c_str()) != 0) return failure("cannot be replaced", errno);
  forget_temporary_file(std::exchange(temporary_, {}));
  return {};
}

Result<void> write_file_atomically(const std::filesystem::path& destination, std::string_view text) {
  auto file = AtomicFile::create(destination);
  if (!file) return file.error();
  if (auto written = file->write(text); !written) return written;
  return file->commit();
}

Result<void> check_writable(const std::filesystem::path& destination) {
  remove_abandoned_files(destination);
  std::vector<std::filesystem::path> absent;  // the innermost first
  std::error_code ignored;
  for (std::filesystem::path folder = folder_of(destination);
       !folder.empty() && !std::filesystem::exists(folder, ignored); folder = folder.parent_path()) {
    absent.push_back(folder);
  }
  Result<void> result;
  {
    auto file = AtomicFile::create(destination);  // made and removed again
    if (!file) result = file.error();
  }
  for (const auto& folder : absent) ::rmdir(folder.c_str());
  return result;
}

}  // namespace scanknit
