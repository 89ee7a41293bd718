// The lossless depth codec "dz1", designed for the statistics of depth pictures.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/result.h"

namespace scanknit {

/// Depth of 16 bits (little endian, an even number of bytes, row after row) becomes
///   d[i] = v[i] - v[i - 1] modulo 2^16, with v[-1] = 0: neighbours are alike;
///   z[i] = (d[i] << 1) ^ (d[i] >> 15, arithmetic): small numbers of either sign have a high byte of zero;
///   all low bytes of z, then all high bytes: one plane of noise, one of long runs;
/// and that as one zstd frame of level 1.
[[nodiscard]] std::vector<std::byte> encode_depth(std::span<const std::byte> z16);

/// Decodes 2 * `pixels` bytes. The caller has checked `pixels` against the limits. Errors (kInput, without `where`):
/// another number of pixels, truncated, corrupt.
[[nodiscard]] Result<std::vector<std::byte>> decode_depth(std::span<const std::byte> packed, std::size_t pixels);

}  // namespace scanknit
