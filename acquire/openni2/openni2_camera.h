// A camera of an OpenNI2 driver (Xtion, Carmine), or an .oni file that its player shows, as a DeviceSource. Part of the
// module, not of the room's library.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "acquire/device_source.h"

namespace scanknit {

[[nodiscard]] Result<std::vector<DeviceInfo>> list_openni2_cameras();

/// Depth in the camera's units, moved into the colour camera where the driver can do that; the left side on the left.
/// Intrinsics come from the field of view that the driver states. Errors (kDevice): the library does not start, or the
/// camera cannot be opened or has no depth.
[[nodiscard]] Result<std::unique_ptr<DeviceSource>> open_openni2_camera(const std::string& uri,
                                                                        const DeviceOptions& options);

}  // namespace scanknit
