// CRC-32 as PNG, MCAP and zlib count it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace scanknit {

/// The CRC-32 of PNG's annex D (IEEE 802.3). `before`: the CRC of the bytes that came first, to go on from there.
[[nodiscard]] std::uint32_t crc32(std::span<const std::byte> bytes, std::uint32_t before = 0);

}  // namespace scanknit
