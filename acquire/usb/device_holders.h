// Finds the programs that have a device file open.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace scanknit {

struct DeviceHolder {
  int process = 0;
  std::string program;
};

/// The device files of a USB device: its own (`node`), and the /dev/videoN that the kernel made for it. `port` as in
/// /sys/bus/usb/devices.
[[nodiscard]] std::vector<std::filesystem::path> device_nodes(const std::filesystem::path& node,
                                                              const std::string& port,
                                                              const std::filesystem::path& sysfs = "/sys");

/// Other processes that have one of `nodes` open, as far as this process may see: those of other users are hidden.
/// Without udev, which opens a device when it is plugged in.
[[nodiscard]] std::vector<DeviceHolder> find_holders(const std::vector<std::filesystem::path>& nodes,
                                                     const std::filesystem::path& proc = "/proc");

/// "process 812 (cheese), process 900 (obs)"; empty for none.
[[nodiscard]] std::string describe_holders(const std::vector<DeviceHolder>& holders);

}  // namespace scanknit
