// PartFolder: a folder for files that a scan needs until it ends.
#pragma once

#include <filesystem>
#include <utility>

#include "core/result.h"

namespace scanknit {

/// Hidden beside a file that the scan will write, where there is room for large files; removed with all that is in it
/// when the object ends. Killed: by the next scan that writes this file.
class PartFolder {
 public:
  /// Also removes those that killed scans left for the same file. Errors: kOutput.
  [[nodiscard]] static Result<PartFolder> create(const std::filesystem::path& beside);

  PartFolder(PartFolder&& other) noexcept
      : path_(std::move(other.path_)), descriptor_(std::exchange(other.descriptor_, -1)) {}
  PartFolder& operator=(PartFolder&&) = delete;
  PartFolder(const PartFolder&) = delete;
  PartFolder& operator=(const PartFolder&) = delete;
  ~PartFolder();

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

  /// Gives the folder, with all that is in it, its final name beside the hidden one; it is not removed then. Others may
  /// read it as the umask allows. Errors (kOutput): a folder that is not empty, or a file, has that name.
  [[nodiscard]] Result<void> keep_as(const std::filesystem::path& path);

 private:
  PartFolder(std::filesystem::path path, int descriptor) : path_(std::move(path)), descriptor_(descriptor) {}

  std::filesystem::path path_;
  int descriptor_;  ///< locked while the folder is in use; -1: moved from
};

}  // namespace scanknit
