// AtomicFile: all-or-nothing output. Until commit() succeeds the destination is exactly what it was before.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "core/result.h"

namespace scanknit {

/// Writes to a hidden temporary file beside the destination; commit() does flush, fsync, rename and fsync of the
/// folder. Destroyed without commit: the temporary file is removed. A destination that is a symbolic link is replaced
/// by the file, not followed. Errors are ErrorCode::kOutput with the system's reason.
class AtomicFile {
 public:
  [[nodiscard]] static Result<AtomicFile> create(const std::filesystem::path& destination);

  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile& operator=(AtomicFile&& other) noexcept;
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  ~AtomicFile();

  [[nodiscard]] Result<void> write(std::span<const std::byte> bytes);
  [[nodiscard]] Result<void> write(std::string_view text);

  /// Where libraries that insist on a file name may write instead of write(). They must leave the file in place.
  [[nodiscard]] const std::filesystem::path& temporary_path() const { return temporary_; }

  /// After this the object is spent.
  [[nodiscard]] Result<void> commit();

 private:
  AtomicFile(std::filesystem::path destination, std::filesystem::path temporary, int descriptor);
  [[nodiscard]] Result<void> flush();
  [[nodiscard]] Error failure(std::string_view what, int error_number) const;
  void discard() noexcept;

  std::filesystem::path destination_;
  std::filesystem::path temporary_;
  int descriptor_ = -1;
  std::string buffer_;
};

/// One call for small files.
[[nodiscard]] Result<void> write_file_atomically(const std::filesystem::path& destination, std::string_view text);

/// Asks, before any long work, whether `destination` could be written: its folder exists (or can be made) and is
/// writable, and it is not a folder itself. Leaves nothing behind: folders that it had to make are gone again.
[[nodiscard]] Result<void> check_writable(const std::filesystem::path& destination);

}  // namespace scanknit
