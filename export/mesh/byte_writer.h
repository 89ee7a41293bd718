// ByteWriter: writes many small values to an AtomicFile, little-endian, and keeps the first error until the end.
#pragma once

#include <Eigen/Core>
#include <bit>
#include <cstring>
#include <string>
#include <string_view>

#include "core/files/atomic_file.h"

namespace scanknit {

/// After an error it writes nothing more; finish() reports the error. Therefore writers need no checks between values.
class ByteWriter {
 public:
  explicit ByteWriter(AtomicFile& file) : file_(file) { block_.reserve(2 * kBlockBytes); }

  template <typename T>
  void put(T value) {
    static_assert(std::endian::native == std::endian::little, "the file formats are little-endian");
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    append({raw, sizeof(T)});
  }
  void put(const Eigen::Vector3f& v) {
    put(v.x());
    put(v.y());
    put(v.z());
  }
  void text(std::string_view characters) { append(characters); }

  /// Writes the rest to the file. Call it once, at the end.
  [[nodiscard]] Result<void> finish() {
    flush();
    return status_;
  }

 private:
  static constexpr std::size_t kBlockBytes = 1u << 16;

  void append(std::string_view characters) {
    block_.append(characters);
    if (block_.size() >= kBlockBytes) flush();
  }
  void flush() {
    if (status_) status_ = file_.write(block_);
    block_.clear();
  }

  AtomicFile& file_;
  std::string block_;
  Result<void> status_;
};

}  // namespace scanknit
