// Unpacks an LZ4 frame, as ROS 1 bags and MCAP files have.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/result.h"

namespace scanknit {

/// Unpacks `size` bytes, which the caller has checked against the limits. Errors (kInput, without `where`): another
/// size, corrupt, or not one LZ4 frame.
[[nodiscard]] Result<std::vector<std::byte>> lz4_unpack(std::span<const std::byte> packed, std::size_t size);

}  // namespace scanknit
