// UvcCamera: a UVC depth camera as a DeviceSource.
#pragma once

#include <memory>
#include <stop_token>

#include "acquire/device_source.h"
#include "acquire/usb/usb_context.h"
#include "acquire/uvc/uvc_descriptors.h"

namespace scanknit {

/// The device's video functions when one of them offers depth, else nothing.
[[nodiscard]] std::vector<UvcFunction> depth_functions_of(const UsbDeviceInfo& device);

/// As list_cameras() names it.
[[nodiscard]] DeviceInfo describe_camera(const UsbDeviceInfo& device);

/// Opens and claims it. Errors (kDevice): no depth camera, forbidden, in use, unplugged. A stop, also later, lets a
/// camera that does not answer be waited for more shortly.
[[nodiscard]] Result<std::unique_ptr<DeviceSource>> open_uvc_camera(UsbContext& context, const UsbDeviceInfo& device,
                                                                    const DeviceOptions& options, std::stop_token stop);

}  // namespace scanknit
