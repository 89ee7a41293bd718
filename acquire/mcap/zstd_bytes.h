// Bytes through zstd at level 1: the level that keeps up with a camera.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/result.h"

namespace scanknit {

/// One zstd frame that states its content's size.
[[nodiscard]] std::vector<std::byte> zstd_pack(std::span<const std::byte> bytes);

/// The `size` bytes that `packed` holds. Nothing is allocated before `packed` has said the same size: the caller has
/// checked it against the limits. Errors (kInput, without `where`): another size, corrupt, or not one zstd frame.
[[nodiscard]] Result<std::vector<std::byte>> zstd_unpack(std::span<const std::byte> packed, std::size_t size);

}  // namespace scanknit
