// Picture messages: a RawFrame as the data of one message of a recording.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "acquire/raw_frame.h"
#include "core/limits.h"
#include "core/result.h"

namespace scanknit {

/// 32 bytes of header (docs/recordings.md) and the picture: depth by the codec dz1, MJPEG as the camera sent it, every
/// other format through zstd. The clocks are not in it: they are the message's own times.
[[nodiscard]] std::vector<std::byte> pack_picture(const RawFrame& frame);

/// The frame of pack_picture, its times 0. Errors (kInput, without `where`): truncated, of another version, larger than
/// the limits, contradicting itself, corrupt.
[[nodiscard]] Result<RawFrame> unpack_picture(std::span<const std::byte> message, const Limits& limits);

}  // namespace scanknit
