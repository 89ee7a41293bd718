// Picture messages: packs a RawFrame into one message of a recording.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "acquire/raw_frame.h"
#include "core/limits.h"
#include "core/result.h"

namespace scanknit {

/// 32 bytes of header (docs/recordings.md) and the picture: depth by the codec dz1, MJPEG as the camera sent it, every
/// other format compressed with zstd. It does not have the clocks, which are the message's own times.
[[nodiscard]] std::vector<std::byte> pack_picture(const RawFrame& frame);

/// Unpacks the frame of pack_picture(), with times 0. Errors (kInput, without `where`): truncated, another version,
/// larger than the limits, inconsistent, corrupt.
[[nodiscard]] Result<RawFrame> unpack_picture(std::span<const std::byte> message, const Limits& limits);

}  // namespace scanknit
