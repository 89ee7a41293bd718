// What a UVC camera offers to a scan: which of its streams are depth and which colour that goes with it.
#pragma once

#include <cstdint>
#include <vector>

#include "acquire/raw_frame.h"
#include "acquire/usb/quirks.h"
#include "acquire/uvc/uvc_descriptors.h"

namespace scanknit {

/// Where a profile is found in a camera's descriptors, whose parts it points to.
struct UvcSelection {
  StreamProfile profile;
  const UvcFunction* function = nullptr;
  const UvcStreamingInterface* stream = nullptr;
  const UvcFormat* format = nullptr;
  const UvcFrameSize* size = nullptr;
  std::uint32_t interval_100ns = 0;
};

/// All that can be asked for, in the camera's order. Left out: 16-bit grey of a camera that has pictures named depth
/// (its infrared ones); pairs of infrared pictures (Y8I) but a RealSense's, whose baseline can be read; colour of an
/// interface that sends depth, since it sends one of them at a time; and, of a RealSense, all colour of the function
/// that has depth (infrared pictures with the names of colours).
[[nodiscard]] std::vector<UvcSelection> selections_of(const std::vector<UvcFunction>& functions,
                                                      const CameraQuirk& quirk);

}  // namespace scanknit
