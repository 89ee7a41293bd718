// The first Kinect (Xbox 360, Kinect for Windows v1) through libfreenect, as a DeviceSource.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "acquire/device_source.h"
#include "acquire/usb/usb_context.h"

namespace scanknit {

inline constexpr std::uint16_t kKinect1Vendor = 0x045e;
/// Cameras of the Kinect for Xbox 360 and of the Kinect for Windows.
inline constexpr std::array<std::uint16_t, 2> kKinect1Products = {0x02ae, 0x02bf};

/// True for the camera of a first Kinect; its motor and microphones are separate devices.
[[nodiscard]] bool is_kinect1(const UsbDeviceInfo& device);

/// Describes the `index`-th Kinect that is plugged in, from 0, by bus and address. The URI has the serial number, or
/// the index if there is none: some Kinects have only zeros there.
[[nodiscard]] DeviceInfo describe_kinect1(const UsbDeviceInfo& device, int index);

/// Opens a Kinect. Depth comes in millimetres, registered to the colour camera by the Kinect's own tables, so that both
/// have the same pose and intrinsics. `info`: from describe_kinect1(). Errors (kDevice): absent, no permission, in use.
[[nodiscard]] Result<std::unique_ptr<DeviceSource>> open_kinect1(const UsbDeviceInfo& device, DeviceInfo info,
                                                                 const DeviceOptions& options);

}  // namespace scanknit
