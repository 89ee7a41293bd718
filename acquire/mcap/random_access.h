// RandomAccess: reads bytes at any position of a file, which need not fit into memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "core/result.h"

namespace scanknit {

class RandomAccess {
 public:
  virtual ~RandomAccess() = default;
  [[nodiscard]] virtual std::uint64_t size() const = 0;

  /// Fills `to` with the bytes from `offset` on; false when some of them do not exist or cannot be read.
  [[nodiscard]] virtual bool read(std::uint64_t offset, std::span<std::byte> to) const = 0;

  /// The first byte from `offset` on that is not in a hole, which reads as zeros; `offset` itself where holes are not
  /// known, size() where nothing else comes.
  [[nodiscard]] virtual std::uint64_t next_data(std::uint64_t offset) const { return offset; }
};

/// Opens a file, read with pread. The file may grow or shrink meanwhile. Errors (kInput): it does not exist, is not a
/// regular file, or has no permission.
[[nodiscard]] Result<std::unique_ptr<RandomAccess>> open_random_access(const std::filesystem::path& path);

/// Bytes in memory, which outlive it.
class MemoryAccess final : public RandomAccess {
 public:
  explicit MemoryAccess(std::span<const std::byte> bytes) : bytes_(bytes) {}
  [[nodiscard]] std::uint64_t size() const override { return bytes_.size(); }
  [[nodiscard]] bool read(std::uint64_t offset, std::span<std::byte> to) const override;

 private:
  std::span<const std::byte> bytes_;
};

}  // namespace scanknit
