// The video modes of an OpenNI2 camera.
#pragma once

#include <vector>

#include "acquire/raw_frame.h"

struct _OniDevice;  // OpenNI2's type for a device

namespace scanknit {

/// A video mode that we can use. The profile has everything except the library's own pixel format.
struct OniMode {
  int pixel_format = 0;  ///< OniPixelFormat
  StreamProfile profile;
};

/// Lists each profile once. Prefers millimetres to tenths of a millimetre, which reach only 6.5 m.
[[nodiscard]] std::vector<OniMode> modes_of(_OniDevice* device, StreamKind kind);

}  // namespace scanknit
