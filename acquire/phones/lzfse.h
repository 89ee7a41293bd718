// Unpacks LZFSE, Apple's compression, which Debian has no library for. By the description of the format in its
// reference implementation (github.com/lzfse/lzfse).
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/result.h"

namespace scanknit {

/// The bytes of a stream of blocks, up to the block that ends it; what follows is not looked at. Errors (kInput,
/// without `where`): truncated, damaged, or more than `max_bytes` when unpacked.
[[nodiscard]] Result<std::vector<std::byte>> unpack_lzfse(std::span<const std::byte> packed, std::size_t max_bytes);

}  // namespace scanknit
