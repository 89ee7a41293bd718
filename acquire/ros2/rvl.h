// Depth packed by RVL: runs of pixels without and with depth, and the differences within the latter.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/image.h"

namespace scanknit {

/// A picture of width x height pixels, both > 0 (Wilson 2017, "Fast lossless depth image compression"): numbers in
/// groups of three bits, the lowest first, a fourth bit says that another follows; eight groups make a little-endian
/// word, the first in its highest bits. Nothing: `packed` ends too early, or tells of more pixels than there are.
[[nodiscard]] std::optional<Image<std::uint16_t>> unpack_rvl(std::span<const std::byte> packed, int width, int height);

}  // namespace scanknit
