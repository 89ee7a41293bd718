// The CRC-32 of PNG, MCAP and zlib.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace scanknit {

/// The CRC-32 of PNG's annex D (IEEE 802.3). `before`: the CRC of the bytes before these, to continue it.
[[nodiscard]] std::uint32_t crc32(std::span<const std::byte> bytes, std::uint32_t before = 0);

}  // namespace scanknit
