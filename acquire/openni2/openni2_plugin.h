// The OpenNI2 driver is a separate module, libscanknit_openni2.so: nothing else needs libOpenNI2.
#pragma once

#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "acquire/device_source.h"

namespace scanknit {

/// What the module offers (core/system/module.h).
struct OpenNi2Plugin {
  /// Cameras that OpenNI2's drivers see. Error (kDevice): the library does not start.
  Result<std::vector<DeviceInfo>> (*list)();

  /// `uri` is one of list(), or "openni2:/path/file.oni". Errors (kDevice): it cannot be opened.
  Result<std::unique_ptr<DeviceSource>> (*open)(const std::string& uri, const DeviceOptions& options);
};

inline constexpr const char* kOpenNi2Prefix = "openni2:";

/// Errors (kDevice): the module is not there, or was built with another ScanKnit, or libOpenNI2 is missing; says what
/// to do.
[[nodiscard]] Result<const OpenNi2Plugin*> load_openni2();

/// `uri`: "openni2:" (the first), one of the plugin's, or "openni2:/path/file.oni", which is played at its own pace.
/// As open_camera(): waits for DeviceOptions::wait_s, and for the same camera again for reconnect_s.
[[nodiscard]] Result<std::unique_ptr<DeviceSource>> open_openni2(const std::string& uri, const DeviceOptions& options,
                                                                 const std::stop_token& stop);

/// The plugin's cameras; none if it cannot be loaded.
[[nodiscard]] std::vector<DeviceInfo> list_openni2();

}  // namespace scanknit
