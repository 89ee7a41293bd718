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

  /// False when another file, or none, has the path by now: nobody would find what is appended.
  [[nodiscard]] bool is_in_place() const;
  /// Takes it away, if it is in its place.
  void remove() const;

 private:
  AppendFile(std::filesystem::path path, int descriptor) : path_(std::move(path)), descriptor_(descriptor) {}

  std::filesystem::path path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

/// Some program has an AppendFile there.
[[nodiscard]] bool is_being_appended(const std::filesystem::path& path);

}  // namespace scanknit
