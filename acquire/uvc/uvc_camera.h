// UvcCamera: a UVC depth camera as a DeviceSource.
#pragma once

#include <memory>
#include <stop_token>

#include "acquire/device_source.h"
#include "acquire/usb/usb_context.h"
#include "acquire/uvc/uvc_descriptors.h"

namespace scanknit {

/// The device's video functions if one of them offers depth, else none.
[[nodiscard]] std::vector<UvcFunction> depth_functions_of(const UsbDeviceInfo& device);

/// The camera's entry in list_cameras().
[[nodiscard]] DeviceInfo describe_camera(const UsbDeviceInfo& device);

/// Opens and claims the camera. Errors (kDevice): no depth camera, no permission, in use, unplugged. A stop request,
/// also a later one, shortens the wait for a camera that does not answer.
[[nodiscard]] Result<std::unique_ptr<DeviceSource>> open_uvc_camera(UsbContext& context, const UsbDeviceInfo& device,
                                                                    const DeviceOptions& options, std::stop_token stop);

}  // namespace scanknit
