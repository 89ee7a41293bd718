// The blocks of an LZFSE stream. Private to the decoder.
#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "core/files/byte_reader.h"

namespace scanknit {

/// What is unpacked so far, of all blocks: a match may reach back into earlier ones.
class LzOutput {
 public:
  explicit LzOutput(std::size_t max_bytes) : max_bytes_(max_bytes) {}

  /// A block of `count` bytes comes next; false: that is too much.
  [[nodiscard]] bool begin_block(std::size_t count) {
    if (count > max_bytes_ - bytes_.size()) return false;
    end_ = bytes_.size() + count;
    return true;
  }
  [[nodiscard]] bool is_block_full() const { return bytes_.size() == end_; }

  /// False, here and below: the block would have more bytes than it states.
  [[nodiscard]] bool append(std::span<const std::byte> literals) {
    if (literals.size() > end_ - bytes_.size()) return false;
    bytes_.insert(bytes_.end(), literals.begin(), literals.end());
    return true;
  }
  /// `count` bytes from `distance` bytes back on, which may overlap what they become; false, too: from before the
  /// start.
  [[nodiscard]] bool append_match(std::size_t distance, std::size_t count) {
    if (count == 0) return true;
    if (distance == 0 || distance > bytes_.size() || count > end_ - bytes_.size()) return false;
    const std::size_t at = bytes_.size();
    bytes_.resize(at + count);
    for (std::size_t i = at; i < at + count; ++i) bytes_[i] = bytes_[i - distance];
    return true;
  }

  [[nodiscard]] std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::size_t max_bytes_;
  std::size_t end_ = 0;
  std::vector<std::byte> bytes_;
};

// Each reads one block behind its four letters; false: it is truncated or damaged.

/// "bvx1", whose tables are plain, and "bvx2", whose tables are packed.
[[nodiscard]] bool unpack_fse_block(ByteReader& reader, bool has_packed_tables, LzOutput& output);

/// "bvxn", LZVN.
[[nodiscard]] bool unpack_lzvn_block(ByteReader& reader, LzOutput& output);

}  // namespace scanknit
