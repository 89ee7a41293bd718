// Folder: a bounded, ordered listing of a directory, and checks of names that must not lead out of it.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/replay/recording.h"
#include "core/limits.h"
#include "core/result.h"

namespace scanknit {

/// Names in natural order ("frame2" before "frame10").
struct Folder {
  std::filesystem::path path;
  std::vector<std::string> files;
  std::vector<std::string> folders;

  [[nodiscard]] bool has_file(std::string_view name) const;
  [[nodiscard]] bool has_folder(std::string_view name) const;
};

/// Without hidden entries: a Mac leaves `._NAME` beside each NAME. Errors (kInput): not a folder, no permission, more
/// entries than a recording may have.
[[nodiscard]] Result<Folder> list_folder(const std::filesystem::path& path, const Limits& limits);

/// Digit runs compare as numbers; equal numbers and everything else as bytes. A strict weak ordering.
[[nodiscard]] bool natural_less(std::string_view a, std::string_view b);

/// `name`, written in a file of the recording at `folder`, as a path. Dropped (kUnsafePath): absolute, with "..", or
/// leading out of the folder through a symbolic link. The file need not exist.
[[nodiscard]] OrDrop<std::filesystem::path> resolve_inside(const std::filesystem::path& folder, std::string_view name);

}  // namespace scanknit
