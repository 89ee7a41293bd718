// The temporary files of AtomicFile: those of this process, and those that a killed one left.
#pragma once

#include <filesystem>

#include "core/result.h"

namespace scanknit {

/// A new temporary file, hidden beside `destination`, locked by this process and listed for remove_temporary_files().
struct TemporaryFile {
  std::filesystem::path path;
  int descriptor = -1;
};
/// Errors: kOutput with the system's reason; `where` is the destination.
[[nodiscard]] Result<TemporaryFile> create_temporary_file(const std::filesystem::path& destination);

/// The file was removed, or has its final name.
void forget_temporary_file(const std::filesystem::path& path) noexcept;

/// Removes all temporary files of this process, before it exits without destructors.
void remove_temporary_files() noexcept;

/// Removes the temporary files of `destination` that no process has locked, and that are older than a minute.
void remove_abandoned_files(const std::filesystem::path& destination) noexcept;

}  // namespace scanknit
