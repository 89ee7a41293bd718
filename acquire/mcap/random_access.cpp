#include "acquire/mcap/random_access.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace scanknit {
namespace {

class FileAccess final : public RandomAccess {
 public:
  FileAccess(int descriptor, std::uint64_t size) : descriptor_(descriptor), size_(size) {}
  ~FileAccess() override { ::close(descriptor_); }
  FileAccess(const FileAccess&) = delete;
  FileAccess& operator=(const FileAccess&) = delete;

  [[nodiscard]] std::uint64_t size() const override { return size_; }

  [[nodiscard]] bool read(std::uint64_t offset, std::span<std::byte> to) const override {
    if (offset > size_ || to.size() > size_ - offset) return false;
    while (!to.empty()) {
      const ssize_t count = ::pread(descriptor_, to.data(), to.size(), static_cast<off_t>(offset));
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) return false;
      offset += static_cast<std::uint64_t>(count);
      to = to.subspan(static_cast<std::size_t>(count));
    }
    return true;
  }

  [[nodiscard]] std::uint64_t next_data(std::uint64_t offset) const override {
    const off_t found = ::lseek(descriptor_, static_cast<off_t>(offset), SEEK_DATA);
    if (found >= 0) return static_cast<std::uint64_t>(found);
    return errno == ENXIO ? size_ : offset;
  }

 private:
  int descriptor_;
  std::uint64_t size_;
};

}  // namespace

Result<std::unique_ptr<RandomAccess>> open_random_access(const std::filesystem::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);  // a pipe must not block us
  if (descriptor < 0) return Error{ErrorCode::kInput, std::strerror(errno), path.string()};
  struct stat status {};
  if (::fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) {
    ::close(descriptor);
    return Error{ErrorCode::kInput, "not a regular file", path.string()};
  }
  return std::unique_ptr<RandomAccess>(
      std::make_unique<FileAccess>(descriptor, static_cast<std::uint64_t>(status.st_size)));
}

bool MemoryAccess::read(std::uint64_t offset, std::span<std::byte> to) const {
  if (offset > bytes_.size() || to.size() > bytes_.size() - offset) return false;
  const auto part = bytes_.subspan(static_cast<std::size_t>(offset), to.size());
  std::copy(part.begin(), part.end(), to.begin());
  return true;
}

}  // namespace scanknit
