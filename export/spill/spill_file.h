// SpillFile: keeps bytes that do not fit into memory on disk.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "core/result.h"

namespace scanknit {

/// A file without a name, which disappears with the object or the process. Errors are kOutput with the system's reason.
class SpillFile {
 public:
  /// Creates it in `folder`, which is made if necessary; not in /tmp, which may be in memory.
  [[nodiscard]] static Result<SpillFile> create(const std::filesystem::path& folder);

  SpillFile(SpillFile&& other) noexcept;
  SpillFile& operator=(SpillFile&& other) noexcept;
  SpillFile(const SpillFile&) = delete;
  SpillFile& operator=(const SpillFile&) = delete;
  ~SpillFile();

  [[nodiscard]] Result<void> append(std::span<const std::byte> bytes);
  [[nodiscard]] std::uint64_t size() const { return size_; }
  /// Reads `bytes` from `offset` on; these must have been appended. Several threads may read at once while none
  /// appends.
  [[nodiscard]] Result<void> read(std::uint64_t offset, std::span<std::byte> bytes) const;

 private:
  SpillFile(std::filesystem::path folder, int descriptor);
  [[nodiscard]] Error failure(const char* what, int error_number) const;

  std::filesystem::path folder_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace scanknit
