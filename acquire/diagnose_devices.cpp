#include "acquire/diagnose_devices.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <set>

#include "acquire/device_rules.h"
#include "acquire/kinect1/kinect1_camera.h"
#include "acquire/openni2/openni2_plugin.h"
#include "acquire/usb/device_holders.h"
#include "acquire/usb/link_speed.h"
#include "acquire/usb/quirks.h"
#include "acquire/usb/usb_context.h"
#include "acquire/uvc/uvc_camera.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using Grade = Finding::Grade;

constexpr const char* kUsbMemory = "/sys/module/usbcore/parameters/usbfs_memory_mb";
constexpr int kUsualUsbMemoryMb = 16;
// Depth and colour as YUYV, 640x480 at 30 frames a second: what capture asks for unless told otherwise.
constexpr double kUsualBytesPerSecond = 2 * 640 * 480 * 2 * 30;

constexpr std::uint16_t kPrimeSense = 0x1d27;  // of Carmine and Xtion: cameras for the OpenNI2 module

bool is_known(const UsbDeviceInfo& device) {
  return quirk_of(device.vendor, device.product).vendor != 0;
}

Finding permission_of(const UsbDeviceInfo& device) {
  const std::string node = device.node();
  if (::access(node.c_str(), R_OK | W_OK) == 0)
    return {Grade::kGood, "permission: " + node + " can be read and written", ""};
  return {Grade::kProblem, "permission: " + node + " may not be read and written",
          rules_command(device.vendor, device.product) + ", then re-plug the camera"};
}

/// The kernel's driver of each video interface, as sysfs has it.
std::set<std::string> drivers_of(const std::string& port) {
  std::set<std::string> drivers;
  std::error_code ignored;
  const fs::path folder = fs::path("/sys/bus/usb/devices") / port;
  for (fs::directory_iterator it(folder, ignored), end; !ignored && it != end; it.increment(ignored)) {
    if (!it->path().filename().string().starts_with(port + ":")) continue;
    const fs::path driver = fs::read_symlink(it->path() / "driver", ignored);
    if (!ignored) drivers.insert(driver.filename().string());
    ignored.clear();
  }
  return drivers;
}

Finding driver_of(const UsbDeviceInfo& device) {
  std::string names;
  for (const std::string& name : drivers_of(device.port)) names += (names.empty() ? "" : ", ") + name;
  if (names.empty()) return {Grade::kGood, "driver: the kernel has none bound", ""};
  return {Grade::kNote, "driver: the kernel has " + names + " bound; it is put aside while scanning and comes back",
          ""};
}

Finding use_of(const UsbDeviceInfo& device) {
  const auto holders = find_holders(device_nodes(device.node(), device.port));
  if (holders.empty()) return {Grade::kGood, "use: no other program has it open (as far as we may see)", ""};
  return {Grade::kProblem, "use: it is open in " + describe_holders(holders),
          "close that program, or take the camera from it with --force"};
}

Finding link_of(const UsbDeviceInfo& device) {
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(),
                "link: %d Mbit/s; 640x480 depth and colour at 30 frames a second need %.1f MB/s", device.speed_mbit,
                kUsualBytesPerSecond / 1e6);
  if (device.speed_mbit >= kSuperSpeedMbit) return {Grade::kGood, text.data(), ""};
  const bool is_enough = device.speed_mbit == 480 && kUsualBytesPerSecond < kHighSpeedBytesPerSecond;
  return {is_enough ? Grade::kNote : Grade::kProblem,
          std::string(text.data()) + (is_enough ? ", which nearly fills it" : ""),
          "use a USB 3 port (blue) and a USB 3 cable, and plug it in quickly: a slow hand makes it fall back to USB 2"};
}

DeviceInfo describe_primesense(const UsbDeviceInfo& device) {
  DeviceInfo info;
  info.uri = kOpenNi2Prefix;
  info.name = "PrimeSense camera (Carmine, Xtion)";
  info.bus = device.bus;
  info.address = device.address;
  info.speed_mbit = device.speed_mbit;
  info.support = "should work";
  return info;
}

Finding module_of() {
  if (const auto module = load_openni2(); !module) {
    return {Grade::kProblem, "OpenNI2: " + module.error().message, "see docs/devices.md, OpenNI2"};
  }
  return {Grade::kGood, "OpenNI2: its module is there", ""};
}

std::vector<Finding> findings_of(const UsbDeviceInfo& device) {
  std::vector<Finding> findings;
  if (device.vendor == kPrimeSense) {  // made for USB 2, as a Kinect is
    return {permission_of(device), driver_of(device), use_of(device), module_of()};
  }
  const bool is_kinect = is_kinect1(device);
  if (!is_kinect && depth_functions_of(device).empty()) {
    findings.push_back({Grade::kProblem,
                        "configuration: the system did not set the camera up, or it is in an update mode",
                        "plug it into the computer itself or into a powered hub; dmesg tells more"});
  }
  findings.push_back(permission_of(device));
  findings.push_back(driver_of(device));
  findings.push_back(use_of(device));
  if (!is_kinect) findings.push_back(link_of(device));  // a Kinect knows USB 2 only, and is made for it
  return findings;
}

Finding usb_memory() {
  int megabytes = 0;
  if (!(std::ifstream(kUsbMemory) >> megabytes)) return {Grade::kNote, "USB memory: the system's limit is unknown", ""};
  const std::string text = fmt::format("USB memory: {} MB for all programs together", megabytes);
  // 0 is "no limit".
  if (megabytes == 0 || megabytes >= kUsualUsbMemoryMb) return {Grade::kGood, text, ""};
  return {Grade::kNote, text + ", less than usual", fmt::format("echo 128 | sudo tee {}", kUsbMemory)};
}

bool is_problem(const Finding& finding) {
  return finding.grade == Grade::kProblem;
}

}  // namespace

bool Diagnosis::has_problem() const {
  return std::any_of(system.begin(), system.end(), is_problem) ||
         std::any_of(devices.begin(), devices.end(), [](const DeviceDiagnosis& device) {
           return std::any_of(device.findings.begin(), device.findings.end(), is_problem);
         });
}

Result<Diagnosis> diagnose_devices() {
  const auto context = UsbContext::create();
  if (!context) return context.error();
  Diagnosis diagnosis;
  diagnosis.system.push_back(usb_memory());
  const auto devices = (*context)->devices();
  int kinects = 0;
  for (const UsbDeviceInfo& device : devices) {
    if (is_kinect1(device)) {
      diagnosis.devices.push_back({describe_kinect1(device, kinects++), findings_of(device)});
      continue;
    }
    if (device.vendor == kPrimeSense) {
      diagnosis.devices.push_back({describe_primesense(device), findings_of(device)});
      continue;
    }
    if (!is_known(device) && depth_functions_of(device).empty()) continue;
    diagnosis.devices.push_back({describe_camera(device), findings_of(device)});
  }
  if (diagnosis.devices.empty()) {
    diagnosis.system.push_back(
        {Grade::kProblem, "no depth camera among " + std::to_string(devices.size()) + " USB devices",
         "plug the camera in; try another cable and port; dmesg shows whether the system sees it"});
    if (const auto module = load_openni2(); !module) {
      diagnosis.system.push_back({Grade::kNote, "OpenNI2 cameras are not looked for: " + module.error().message, ""});
    }
  }
  return diagnosis;
}

}  // namespace scanknit
