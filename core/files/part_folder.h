// PartFolder: a hidden folder, for files that are of use until it ends, or for an output of many files until it is
// whole.
#pragma once

#include <filesystem>
#include <utility>

#include "core/result.h"

namespace scanknit {

/// Hidden beside an output, where there is room for large files; removed with all that is in it when the object ends.
/// Killed: by the next process that writes this output.
class PartFolder {
 public:
  /// Also removes those that killed processes left for the same output. Errors: kOutput.
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

  /// The same in the place of a folder that is there, in one step where the file system can exchange two names. The old
  /// folder is removed with all that is in it; after an error it is as it was.
  [[nodiscard]] Result<void> replace(const std::filesystem::path& path);

 private:
  /// On the disk, and open to others as the umask allows. False: errno says why not.
  [[nodiscard]] bool make_ready() const;

  PartFolder(std::filesystem::path path, int descriptor) : path_(std::move(path)), descriptor_(descriptor) {}

  std::filesystem::path path_;
  int descriptor_;  ///< locked while the folder is in use; -1: moved from
};

}  // namespace scanknit
