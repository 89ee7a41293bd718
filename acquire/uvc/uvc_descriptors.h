// Parses the configuration descriptor of a USB video camera: functions, streams, formats and controls (USB Video Class
// 1.0, 1.1, 1.5).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "acquire/raw_frame.h"
#include "core/result.h"

namespace scanknit {

using UvcGuid = std::array<std::byte, 16>;

/// One picture size of a format.
struct UvcFrameSize {
  std::uint8_t index = 0;
  int width = 0;
  int height = 0;
  std::uint32_t max_frame_bytes = 0;           ///< 0: unknown
  std::uint32_t default_interval_100ns = 0;    ///< the default interval of the camera; 0: unknown
  std::vector<std::uint32_t> intervals_100ns;  ///< discrete ones, or shortest and longest of a range
};

struct UvcFormat {
  std::uint8_t index = 0;
  std::optional<PixelFormat> pixel_format;  ///< nothing: one that we do not read (infrared, H.264 ...)
  bool is_compressed = false;
  bool is_grey = false;  ///< 16-bit grey: depth of cameras that have no name for it, infrared of others
  std::vector<UvcFrameSize> sizes;
};

/// One alternate setting that has a video endpoint. Bulk endpoints are found in alternate 0, isochronous ones in
/// others.
struct UvcAlternate {
  std::uint8_t number = 0;
  std::uint8_t endpoint = 0;  ///< address, bit 7 set: to the computer
  bool is_isochronous = false;
  std::uint16_t packet_bytes = 0;        ///< wMaxPacketSize, without the extra packets of a microframe
  std::uint32_t bytes_per_interval = 0;  ///< all packets of a microframe together
};

struct UvcStreamingInterface {
  std::uint8_t number = 0;
  std::vector<UvcFormat> formats;
  std::vector<UvcAlternate> alternates;
};

struct UvcExtensionUnit {
  std::uint8_t id = 0;
  UvcGuid guid{};
};

/// A VideoControl interface with the streams that belong to it. A camera may have several: one for depth, one for
/// colour.
struct UvcFunction {
  std::uint8_t control_interface = 0;
  std::uint16_t version = 0x0100;    ///< bcdUVC
  std::uint32_t clock_hz = 0;        ///< of the time stamps of UVC 1.0 and 1.1; 0: unknown
  std::uint8_t camera_terminal = 0;  ///< 0: none
  std::uint8_t processing_unit = 0;  ///< 0: none
  std::vector<UvcExtensionUnit> extension_units;
  std::vector<UvcStreamingInterface> streams;
};

/// The functions found in a whole configuration descriptor (9 bytes and all that follow, as GET_DESCRIPTOR gives it).
/// Class-specific descriptors count for the interface they follow, be it directly or after its endpoints. What is not
/// known is skipped; a descriptor that is too short for its kind is skipped as well. No video function: an empty list.
/// Errors (kDevice): a descriptor longer than what is left, or of no length; more functions, streams, formats or sizes
/// than a camera can mean (kMaxUvcItems).
[[nodiscard]] Result<std::vector<UvcFunction>> parse_uvc_configuration(std::span<const std::byte> bytes);

/// Of each list above. A real camera has some thirty sizes a format.
inline constexpr std::size_t kMaxUvcItems = 256;

/// What a format's GUID means to us, or nothing. Depth of every name (Z16, Y16, D16, INVZ) is kZ16.
[[nodiscard]] std::optional<PixelFormat> pixel_format_of(const UvcGuid& guid);

/// Bytes of a picture, or nothing for compressed formats and sizes that do not fit.
[[nodiscard]] std::optional<std::size_t> picture_bytes(PixelFormat format, int width, int height);

}  // namespace scanknit
