// A camera of an OpenNI2 driver (Xtion, Carmine), or an .oni file in OpenNI2's player, as a DeviceSource. Part of the
// module, not of the room's library.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "acquire/device_source.h"

namespace scanknit {

[[nodiscard]] Result<std::vector<DeviceInfo>> list_openni2_cameras();

/// Opens a camera. Depth is in the camera's units, registered to the colour camera if the driver can do that, and not
/// mirrored. Intrinsics come from the driver's field of view. Errors (kDevice): the library does not start, or the
/// camera cannot be opened or has no depth.
[[nodiscard]] Result<std::unique_ptr<DeviceSource>> open_openni2_camera(const std::string& uri,
                                                                        const DeviceOptions& options);

}  // namespace scanknit
