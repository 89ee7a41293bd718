// AppendFile: a file that only grows, and that has only complete pieces at any time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

#include "core/result.h"

namespace scanknit {

class AppendFile {
 public:
  /// Errors (kOutput): a file of this name exists already (a recording cannot be made twice), or the system's reason.
  [[nodiscard]] static Result<AppendFile> create(const std::filesystem::path& path);

  AppendFile(AppendFile&& other) noexcept;
  AppendFile& operator=(AppendFile&&) = delete;
  AppendFile(const AppendFile&) = delete;
  AppendFile& operator=(const AppendFile&) = delete;
  ~AppendFile();

  /// Appends all of `bytes`, normally in one system call, or none: removes a part that was written before the disk was
  /// full. Errors: kOutput.
  [[nodiscard]] Result<void> append(std::span<const std::byte> bytes);

  /// Waits until what has been appended survives a power cut. May be called while another thread appends.
  [[nodiscard]] Result<void> sync() const;

  [[nodiscard]] std::uint64_t size() const { return size_; }

  /// False when the path has no file, or another one, by now: appended data would be lost.
  [[nodiscard]] bool is_in_place() const;
  /// Deletes the file, if it is still at its path.
  void remove() const;

 private:
  AppendFile(std::filesystem::path path, int descriptor) : path_(std::move(path)), descriptor_(descriptor) {}

  std::filesystem::path path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

/// True when any program has an AppendFile at this path.
[[nodiscard]] bool is_being_appended(const std::filesystem::path& path);

}  // namespace scanknit
