// ZIP archives (PKWARE's APPNOTE.TXT, with ZIP64), as far as recordings of phones need them: stored and deflated files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "acquire/mcap/random_access.h"
#include "core/limits.h"
#include "core/result.h"

namespace scanknit {

class ZipArchive {
 public:
  struct Entry {
    std::uint16_t flags = 0, method = 0;
    std::uint32_t crc = 0;
    std::uint64_t packed_bytes = 0, unpacked_bytes = 0;
    std::uint64_t header_at = 0;  ///< the place of the file's own header
  };

  /// Reads the list of files at the archive's end. If that is missing or damaged (`is_torn`), lists the files whose
  /// headers and bytes are whole, from the start on. Errors (kInput, without `where`): no archive.
  [[nodiscard]] static Result<ZipArchive> open(std::shared_ptr<const RandomAccess> file, const Limits& limits);

  [[nodiscard]] const std::map<std::string, Entry>& entries() const { return entries_; }
  [[nodiscard]] bool is_torn() const { return is_torn_; }

  /// The bytes of a file, unpacked, whose check sum is right. Errors (kInput, without `where`): no such file, damaged,
  /// more than `max_bytes`, encrypted or packed in another way.
  [[nodiscard]] Result<std::vector<std::byte>> read(const std::string& name, std::uintmax_t max_bytes) const;

 private:
  explicit ZipArchive(std::shared_ptr<const RandomAccess> file) : file_(std::move(file)) {}

  std::shared_ptr<const RandomAccess> file_;
  std::map<std::string, Entry> entries_;
  bool is_torn_ = false;
};

}  // namespace scanknit
