// What a camera of OpenNI2's offers.
#pragma once

#include <OniCAPI.h>

#include <vector>

#include "acquire/raw_frame.h"

namespace scanknit {

/// What we can use of a video mode.
struct OniMode {
  OniVideoMode oni;
  StreamProfile profile;
};

/// Each profile once: millimetres come before tenths, which reach 6.5 m only.
[[nodiscard]] std::vector<OniMode> modes_of(OniDeviceHandle device, StreamKind kind);

}  // namespace scanknit
