// UvcCamera: a UVC depth camera as a DeviceSource.
#pragma once

#include <memory>

#include "acquire/device_source.h"
#include "acquire/usb/usb_context.h"
#include "acquire/usb/uvc_descriptors.h"

namespace scanknit {

/// The device's video functions when one of them offers depth, else nothing.
[[nodiscard]] std::vector<UvcFunction> depth_functions_of(const UsbDeviceInfo& device);

/// As list_cameras() names it.
[[nodiscard]] DeviceInfo describe_camera(const UsbDeviceInfo& device);

/// Opens and claims it. Errors (kDevice): no depth camera, forbidden, in use, unplugged.
[[nodiscard]] Result<std::unique_ptr<DeviceSource>> open_uvc_camera(UsbContext& context, const UsbDeviceInfo& device,
                                                                    const DeviceOptions& options);

}  // namespace scanknit
