#include "acquire/openni2/openni2_modes.h"

#include <OniCAPI.h>

#include <algorithm>
#include <optional>

namespace scanknit {
namespace {

std::optional<PixelFormat> format_of(OniPixelFormat format) {
  switch (format) {
    case ONI_PIXEL_FORMAT_DEPTH_1_MM:
    case ONI_PIXEL_FORMAT_DEPTH_100_UM: return PixelFormat::kZ16;
    case ONI_PIXEL_FORMAT_RGB888: return PixelFormat::kRgb8;
    case ONI_PIXEL_FORMAT_YUV422: return PixelFormat::kUyvy;
    case ONI_PIXEL_FORMAT_YUYV: return PixelFormat::kYuyv;
    case ONI_PIXEL_FORMAT_JPEG: return PixelFormat::kMjpeg;
    default: return std::nullopt;  // shifts instead of depth, grey
  }
}

}  // namespace

std::vector<OniMode> modes_of(_OniDevice* device, StreamKind kind) {
  std::vector<OniMode> modes;
  const OniSensorInfo* sensor =
      oniDeviceGetSensorInfo(device, kind == StreamKind::kDepth ? ONI_SENSOR_DEPTH : ONI_SENSOR_COLOR);
  for (int i = 0; sensor != nullptr && i < sensor->numSupportedVideoModes; ++i) {
    const OniVideoMode& mode = sensor->pSupportedVideoModes[i];
    const auto format = format_of(mode.pixelFormat);
    if (!format || (*format == PixelFormat::kZ16) != (kind == StreamKind::kDepth)) continue;
    const StreamProfile profile{kind, *format, mode.resolutionX, mode.resolutionY, static_cast<double>(mode.fps)};
    const auto same = std::find_if(modes.begin(), modes.end(), [&](const OniMode& m) { return m.profile == profile; });
    if (same == modes.end()) {
      modes.push_back({mode.pixelFormat, profile});
    } else if (mode.pixelFormat == ONI_PIXEL_FORMAT_DEPTH_1_MM) {
      same->pixel_format = mode.pixelFormat;
    }
  }
  return modes;
}

}  // namespace scanknit
