// Compresses bytes with zstd at level 1, which is fast enough for a camera.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/result.h"

namespace scanknit {

/// One zstd frame that states its content's size. Throws std::bad_alloc.
[[nodiscard]] std::vector<std::byte> zstd_pack(std::span<const std::byte> bytes);

/// True when `bytes` begin as a zstd frame does.
[[nodiscard]] bool is_zstd(std::span<const std::byte> bytes);

/// The size of its content that a zstd frame states; nothing: it states none, or is none.
[[nodiscard]] std::optional<std::uint64_t> zstd_content_size(std::span<const std::byte> packed);

/// Unpacks `size` bytes. Allocates nothing unless `packed` states the same size; the caller has checked it against the
/// limits. Errors (kInput, without `where`): another size, corrupt, or not one zstd frame. Throws std::bad_alloc.
[[nodiscard]] Result<std::vector<std::byte>> zstd_unpack(std::span<const std::byte> packed, std::size_t size);

}  // namespace scanknit
