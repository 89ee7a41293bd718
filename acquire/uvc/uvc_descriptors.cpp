#include "acquire/uvc/uvc_descriptors.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <string_view>

#include "core/checked_math.h"
#include "core/files/byte_reader.h"
#include "core/limits.h"

namespace scanknit {
namespace {

// Standard descriptor types (USB 2.0, table 9-5; USB 3.2, table 9-6) and classes.
constexpr std::uint8_t kInterface = 0x04;
constexpr std::uint8_t kEndpoint = 0x05;
constexpr std::uint8_t kEndpointCompanion = 0x30;
constexpr std::uint8_t kClassInterface = 0x24;
constexpr std::uint8_t kVideoClass = 0x0E;
constexpr std::uint8_t kVideoControl = 0x01;
constexpr std::uint8_t kVideoStreaming = 0x02;
// VideoControl and VideoStreaming descriptor subtypes (UVC 1.5, tables ).
constexpr std::uint8_t kVcHeader = 0x01;
constexpr std::uint8_t kVcInputTerminal = 0x02;
constexpr std::uint8_t kVcProcessingUnit = 0x05;
constexpr std::uint8_t kVcExtensionUnit = 0x06;
constexpr std::uint16_t kCameraTerminalType = 0x0201;
constexpr std::uint8_t kFormatUncompressed = 0x04;
constexpr std::uint8_t kFrameUncompressed = 0x05;
constexpr std::uint8_t kFormatMjpeg = 0x06;
constexpr std::uint8_t kFrameMjpeg = 0x07;
constexpr std::uint8_t kFormatFrameBased = 0x10;
constexpr std::uint8_t kFrameFrameBased = 0x11;

Error hostile(const std::string& what) {
  return {ErrorCode::kDevice, "the camera's descriptors are broken: " + what, "USB configuration"};
}

/// Where class-specific descriptors and endpoints belong at the moment.
enum class Place { kElsewhere, kControl, kStreaming };

class ConfigurationParser {
 public:
  Result<std::vector<UvcFunction>> parse(std::span<const std::byte> bytes);

 private:
  Result<void> one(std::uint8_t type, ByteReader body);
  Result<void> interface(ByteReader body);
  void endpoint(ByteReader body);
  void companion(ByteReader body);
  void control(ByteReader body);
  void streaming(ByteReader body);
  void format(std::uint8_t subtype, ByteReader body);
  void frame(std::uint8_t subtype, ByteReader body);
  UvcStreamingInterface& stream() { return functions_.back().streams.back(); }

  std::vector<UvcFunction> functions_;
  Place place_ = Place::kElsewhere;
  std::uint8_t alternate_ = 0;
  bool is_video_endpoint_ = false;  // the last endpoint was one, so that its companion can be added
  bool is_too_many_ = false;
};

Result<std::vector<UvcFunction>> ConfigurationParser::parse(std::span<const std::byte> bytes) {
  ByteReader reader(bytes);
  while (reader.remaining() > 0) {
    const std::size_t at = reader.offset();
    const auto length = reader.little_endian<std::uint8_t>();
    const auto type = reader.little_endian<std::uint8_t>();
    if (!length || !type || *length < 2) return hostile("no length at byte " + std::to_string(at));
    const auto body = reader.take(*length - 2u);
    if (!body) {
      return hostile("the one at byte " + std::to_string(at) + " has " + std::to_string(*length) + " bytes, only " +
                     std::to_string(bytes.size() - at) + " are left");
    }
    if (const auto done = one(*type, ByteReader(*body)); !done) return done.error();
    if (is_too_many_) return hostile("more than " + std::to_string(kMaxUvcItems) + " entries of one kind");
  }
  return std::move(functions_);
}

Result<void> ConfigurationParser::one(std::uint8_t type, ByteReader body) {
  switch (type) {
    case kInterface: return interface(body);
    case kEndpoint: endpoint(body); break;
    case kEndpointCompanion: companion(body); break;
    case kClassInterface:
      if (place_ == Place::kControl) control(body);
      if (place_ == Place::kStreaming) streaming(body);
      break;
    default: break;
  }
  return {};
}

Result<void> ConfigurationParser::interface(ByteReader body) {
  place_ = Place::kElsewhere;
  is_video_endpoint_ = false;
  const auto number = body.little_endian<std::uint8_t>();
  const auto alternate = body.little_endian<std::uint8_t>();
  if (!body.take(1)) return {};  // bNumEndpoints: the endpoints speak for themselves
  const auto the_class = body.little_endian<std::uint8_t>();
  const auto subclass = body.little_endian<std::uint8_t>();
  if (!subclass || the_class != kVideoClass) return {};
  alternate_ = *alternate;
  if (subclass == kVideoControl) {
    if (alternate_ != 0) return {};  // the standard gives it none
    place_ = Place::kControl;
    if (functions_.size() == kMaxUvcItems) return hostile("too many video functions");
    functions_.emplace_back().control_interface = *number;
  } else if (subclass == kVideoStreaming && !functions_.empty()) {
    place_ = Place::kStreaming;
    auto& streams = functions_.back().streams;
    if (!streams.empty() && streams.back().number == *number) return {};
    if (streams.size() == kMaxUvcItems) return hostile("too many video streams");
    streams.emplace_back().number = *number;
  }
  return {};
}

void ConfigurationParser::endpoint(ByteReader body) {
  is_video_endpoint_ = false;
  const auto address = body.little_endian<std::uint8_t>();
  const auto attributes = body.little_endian<std::uint8_t>();
  const auto max_packet = body.little_endian<std::uint16_t>();
  if (place_ != Place::kStreaming || !max_packet || (*address & 0x80) == 0) return;
  const int transfer = *attributes & 0x03;
  if (transfer != 1 && transfer != 2) return;  // 1 isochronous, 2 bulk
  if (stream().alternates.size() == kMaxUvcItems) {
    is_too_many_ = true;
    return;
  }
  const auto packet = static_cast<std::uint16_t>(*max_packet & 0x07FF);
  const std::uint32_t packets = 1u + ((*max_packet >> 11) & 0x03);  // high speed: up to three a microframe
  stream().alternates.push_back({alternate_, *address, transfer == 1, packet, packet * packets});
  is_video_endpoint_ = true;
}

void ConfigurationParser::companion(ByteReader body) {
  if (!is_video_endpoint_ || !body.take(2)) return;  // bMaxBurst, bmAttributes
  const auto bytes_per_interval = body.little_endian<std::uint16_t>();
  UvcAlternate& alternate = stream().alternates.back();
  if (bytes_per_interval && *bytes_per_interval > 0 && alternate.is_isochronous) {
    alternate.bytes_per_interval = *bytes_per_interval;
  }
}

void ConfigurationParser::control(ByteReader body) {
  UvcFunction& function = functions_.back();
  const auto subtype = body.little_endian<std::uint8_t>();
  if (subtype == kVcHeader) {
    const auto version = body.little_endian<std::uint16_t>();
    if (version) function.version = *version;
    if (!body.take(2)) return;  // wTotalLength
    if (const auto clock = body.little_endian<std::uint32_t>()) function.clock_hz = *clock;
    return;
  }
  const auto id = body.little_endian<std::uint8_t>();
  if (!id) return;
  if (subtype == kVcInputTerminal) {
    if (body.little_endian<std::uint16_t>() == kCameraTerminalType) function.camera_terminal = *id;
  } else if (subtype == kVcProcessingUnit) {
    function.processing_unit = *id;
  } else if (subtype == kVcExtensionUnit) {
    const auto guid = body.take(sizeof(UvcGuid));
    if (!guid) return;
    if (function.extension_units.size() == kMaxUvcItems) {
      is_too_many_ = true;
      return;
    }
    UvcExtensionUnit unit{*id, {}};
    std::copy(guid->begin(), guid->end(), unit.guid.begin());
    function.extension_units.push_back(unit);
  }
}

void ConfigurationParser::streaming(ByteReader body) {
  const auto subtype = body.little_endian<std::uint8_t>();
  if (!subtype) return;
  switch (*subtype) {
    case kFormatUncompressed:
    case kFormatMjpeg:
    case kFormatFrameBased: format(*subtype, body); break;
    case kFrameUncompressed:
    case kFrameMjpeg:
    case kFrameFrameBased: frame(*subtype, body); break;
    default: break;
  }
}

void ConfigurationParser::format(std::uint8_t subtype, ByteReader body) {
  const auto index = body.little_endian<std::uint8_t>();
  if (!body.take(1)) return;  // bNumFrameDescriptors: the sizes speak for themselves
  if (stream().formats.size() == kMaxUvcItems) {
    is_too_many_ = true;
    return;
  }
  UvcFormat found;
  found.index = *index;
  if (subtype == kFormatMjpeg) {
    found.pixel_format = PixelFormat::kMjpeg;
    found.is_compressed = true;
  } else {
    const auto bytes = body.take(sizeof(UvcGuid));
    if (!bytes) return;
    UvcGuid guid;
    std::copy(bytes->begin(), bytes->end(), guid.begin());
    found.pixel_format = pixel_format_of(guid);
    found.is_compressed = found.pixel_format == PixelFormat::kMjpeg;
    found.is_grey = found.pixel_format == PixelFormat::kZ16 && guid[0] == std::byte{'Y'};
  }
  stream().formats.push_back(std::move(found));
}

void ConfigurationParser::frame(std::uint8_t subtype, ByteReader body) {
  if (stream().formats.empty()) return;
  UvcFormat& format = stream().formats.back();
  if (format.sizes.size() == kMaxUvcItems) {
    is_too_many_ = true;
    return;
  }
  UvcFrameSize size;
  const auto index = body.little_endian<std::uint8_t>();
  if (!body.take(1)) return;  // bmCapabilities
  const auto width = body.little_endian<std::uint16_t>();
  const auto height = body.little_endian<std::uint16_t>();
  if (!body.take(8) || *width == 0 || *height == 0) return;  // the bit rates
  const bool is_frame_based = subtype == kFrameFrameBased;
  if (!is_frame_based) {
    const auto max_bytes = body.little_endian<std::uint32_t>();
    if (!max_bytes) return;
    size.max_frame_bytes = *max_bytes;
  }
  const auto default_interval = body.little_endian<std::uint32_t>();
  const auto interval_count = body.little_endian<std::uint8_t>();
  if (!interval_count) return;
  if (is_frame_based) {
    const auto bytes_per_line = body.little_endian<std::uint32_t>();
    if (!bytes_per_line) return;
    const auto bytes = checked_mul<std::uint32_t>(*bytes_per_line, *height);
    size.max_frame_bytes = bytes.value_or(0);
  }
  size.index = *index;
  size.width = *width;
  size.height = *height;
  size.default_interval_100ns = *default_interval;
  // Type 0 is a range: shortest, longest, step.
  const int stated = *interval_count == 0 ? 2 : *interval_count;
  for (int i = 0; i < stated; ++i) {
    const auto interval = body.little_endian<std::uint32_t>();
    if (!interval) break;
    if (*interval > 0) size.intervals_100ns.push_back(*interval);
  }
  if (size.intervals_100ns.empty() && *default_interval > 0) size.intervals_100ns.push_back(*default_interval);
  format.sizes.push_back(std::move(size));
}

}  // namespace

Result<std::vector<UvcFunction>> parse_uvc_configuration(std::span<const std::byte> bytes) {
  return ConfigurationParser().parse(bytes);
}

std::optional<PixelFormat> pixel_format_of(const UvcGuid& guid) {
  // A four-character code, then the tail that all of Microsoft's media GUIDs share.
  constexpr std::array<std::uint8_t, 12> kTail = {0x00, 0x00, 0x10, 0x00, 0x80, 0x00,
                                                  0x00, 0xAA, 0x00, 0x38, 0x9B, 0x71};
  for (std::size_t i = 0; i < kTail.size(); ++i) {
    if (guid[4 + i] != std::byte{kTail[i]}) return std::nullopt;
  }
  struct Code {
    std::string_view text;
    PixelFormat format;
  };
  using namespace std::string_view_literals;
  // D3DFMT_D16 (50) is what RealSense calls depth for Windows; INVZ is the SR300's name.
  constexpr Code kCodes[] = {
      {"Z16 "sv, PixelFormat::kZ16},   {"Y16 "sv, PixelFormat::kZ16},  {"\x50\0\0\0"sv, PixelFormat::kZ16},
      {"INVZ"sv, PixelFormat::kZ16},   {"YUY2"sv, PixelFormat::kYuyv}, {"UYVY"sv, PixelFormat::kUyvy},
      {"MJPG"sv, PixelFormat::kMjpeg}, {"Y8I "sv, PixelFormat::kY8i},
  };
  for (const Code& code : kCodes) {
    if (std::memcmp(guid.data(), code.text.data(), code.text.size()) == 0) return code.format;
  }
  return std::nullopt;
}

std::optional<std::size_t> picture_bytes(PixelFormat format, int width, int height) {
  if (format == PixelFormat::kMjpeg || width < 1 || height < 1) return std::nullopt;
  const bool is_three_bytes = format == PixelFormat::kRgb8 || format == PixelFormat::kBgr8;
  const std::size_t pixel_bytes = is_three_bytes ? 3 : 2;
  const auto pixels = checked_mul<std::int64_t>(width, height);
  if (!pixels || *pixels > Limits{}.max_image_pixels) return std::nullopt;
  return static_cast<std::size_t>(*pixels) * pixel_bytes;
}

}  // namespace scanknit
