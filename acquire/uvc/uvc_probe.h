// The negotiation of a UVC stream: the bytes of the probe and commit controls.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/result.h"

namespace scanknit {

/// What matters of VS_PROBE_CONTROL (UVC 1.5, table 4-75).
struct UvcStreamControl {
  std::uint8_t format_index = 0;
  std::uint8_t frame_index = 0;
  std::uint32_t interval_100ns = 0;
  std::uint32_t max_frame_bytes = 0;    ///< 0 from some cameras: compute it from the size
  std::uint32_t max_payload_bytes = 0;  ///< of one payload, header included
};

/// 26 bytes for UVC 1.0, 34 for 1.1, 48 for 1.5: a camera that is asked for another length may refuse to answer.
[[nodiscard]] std::size_t probe_bytes(std::uint16_t uvc_version);

/// `bytes` is one of the three lengths. The interval is to be kept (bmHint bit 0); what is not named above is 0.
[[nodiscard]] std::vector<std::byte> encode_probe(const UvcStreamControl& control, std::size_t bytes);

/// Any length from 26 on is read: cameras answer more or less than they should. Error (kDevice): shorter.
[[nodiscard]] Result<UvcStreamControl> decode_probe(std::span<const std::byte> bytes);

}  // namespace scanknit
