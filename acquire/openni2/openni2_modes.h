// What a camera of OpenNI2's offers.
#pragma once

#include <vector>

#include "acquire/raw_frame.h"

struct _OniDevice;  // OpenNI2's own, of its handle of a device

namespace scanknit {

/// What we can use of a video mode: all but the library's own pixel format is in the profile.
struct OniMode {
  int pixel_format = 0;  ///< OniPixelFormat
  StreamProfile profile;
};

/// Each profile once: millimetres come before tenths, which reach 6.5 m only.
[[nodiscard]] std::vector<OniMode> modes_of(_OniDevice* device, StreamKind kind);

}  // namespace scanknit
