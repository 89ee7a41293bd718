// AppendFile: a file that only grows, and holds whole pieces at any moment.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

#include "core/result.h"

namespace scanknit {

class AppendFile {
 public:
  /// Errors (kOutput): a file of this name is there already (a recording cannot be made twice), or the system's reason.
  [[nodiscard]] static Result<AppendFile> create(const std::filesystem::path& path);

  AppendFile(AppendFile&& other) noexcept;
  AppendFile& operator=(AppendFile&&) = delete;
  AppendFile(const AppendFile&) = delete;
  AppendFile& operator=(const AppendFile&) = delete;
  ~AppendFile();

  /// All of `bytes` in one system call as a rule, or none: what a full disk cut off is taken back. Errors: kOutput.
  [[nodiscard]] Result<void> append(std::span<const std::byte> bytes);

  /// Waits until what has been appended survives a power cut. May be called while another thread appends.
  [[nodiscard]] Result<void> sync() const;

  [[nodiscard]] std::uint64_t size() const { return size_; }

 private:
  AppendFile(std::filesystem::path path, int descriptor) : path_(std::move(path)), descriptor_(descriptor) {}

  std::filesystem::path path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace scanknit
