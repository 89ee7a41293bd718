#include "acquire/uvc/uvc_selection.h"

#include <algorithm>
#include <cmath>

namespace scanknit {
namespace {

StreamKind kind_of(PixelFormat format) {
  const bool is_for_depth = format == PixelFormat::kZ16 || format == PixelFormat::kY8i;
  return is_for_depth ? StreamKind::kDepth : StreamKind::kColour;
}

bool is_depth(const UvcFormat& format) {
  return format.pixel_format == PixelFormat::kZ16;
}

bool is_pair(const UvcFormat& format) {
  return format.pixel_format == PixelFormat::kY8i;
}

bool is_named_depth(const UvcFormat& format) {
  return is_depth(format) && !format.is_grey;
}

bool has_named_depth(const UvcFunction& function) {
  return std::ranges::any_of(function.streams, [](const UvcStreamingInterface& stream) {
    return std::ranges::any_of(stream.formats, is_named_depth);
  });
}

/// Frames a second to a hundredth: 30, not 30.00003.
double rate_of(std::uint32_t interval_100ns) {
  return std::round(1e9 / interval_100ns) / 100;
}

}  // namespace

std::vector<UvcSelection> selections_of(const std::vector<UvcFunction>& functions, const CameraQuirk& quirk) {
  const bool names_depth = std::ranges::any_of(functions, has_named_depth);
  const auto is_taken_for_depth = [&](const UvcFormat& format) {
    return is_depth(format) && !(format.is_grey && names_depth);
  };
  std::vector<UvcSelection> all;
  for (const UvcFunction& function : functions) {
    const bool is_stereo = quirk.calibration == CalibrationReader::kRealsense && has_named_depth(function);
    for (const UvcStreamingInterface& stream : function.streams) {
      const bool sends_depth = is_stereo || std::ranges::any_of(stream.formats, is_taken_for_depth);
      for (const UvcFormat& format : stream.formats) {
        const bool is_wanted = is_depth(format)  ? is_taken_for_depth(format)
                               : is_pair(format) ? is_stereo
                                                 : !sends_depth;
        if (!format.pixel_format || !is_wanted) continue;
        for (const UvcFrameSize& size : format.sizes) {
          for (const std::uint32_t interval : size.intervals_100ns) {
            const StreamProfile profile{kind_of(*format.pixel_format), *format.pixel_format, size.width, size.height,
                                        rate_of(interval)};
            all.push_back({profile, &function, &stream, &format, &size, interval});
          }
        }
      }
    }
  }
  return all;
}

}  // namespace scanknit
