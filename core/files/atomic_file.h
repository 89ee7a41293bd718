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
/// folder. Destroyed without commit: the temporary file is removed. (Killed: by check_writable() of a later run.) A
/// destination that is a symbolic link is replaced by the file, not followed. Errors are ErrorCode::kOutput with the
/// system's reason.
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

  /// For libraries that write to a file name, in place of write(). They must not rename or delete the file.
  [[nodiscard]] const std::filesystem::path& temporary_path() const { return temporary_; }

  /// The object must not be used after this.
  [[nodiscard]] Result<void> commit();
  /// The same for a file that is of no use after this process: after a power failure it may be anything.
  [[nodiscard]] Result<void> commit_without_sync();

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

/// Writes a small file in one call.
[[nodiscard]] Result<void> write_file_atomically(const std::filesystem::path& destination, std::string_view text);

/// Checks, before any long work, that `destination` can be written: its folder exists (or can be made) and is writable,
/// and it is not a folder itself. Removes all folders that it had to make, and the temporary files that killed
/// processes left there: those of `destination` that are older than a minute and that no process writes.
[[nodiscard]] Result<void> check_writable(const std::filesystem::path& destination);

}  // namespace scanknit
