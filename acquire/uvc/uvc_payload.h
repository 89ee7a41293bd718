// The header that stands before each piece of a UVC picture.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace scanknit {

struct UvcPayloadHeader {
  std::size_t bytes = 0;  ///< of the header: the picture's bytes follow
  bool frame_id = false;  ///< toggles with each picture
  bool is_end = false;    ///< of the picture
  bool has_error = false;
  std::optional<std::uint32_t> presentation_ticks;  ///< the camera's clock when the picture was taken
  std::optional<std::uint32_t> frame_counter;       ///< of RealSense's metadata
};

inline constexpr std::size_t kMaxPayloadHeader = 255;

/// Nothing: fewer bytes than the header says, or a header too short for what its bits promise (UVC 1.5, table 2-6).
/// Metadata that cannot be read is no error: it is optional, and nothing else depends on it.
[[nodiscard]] std::optional<UvcPayloadHeader> parse_payload_header(std::span<const std::byte> payload);

}  // namespace scanknit
