#include "acquire/device_rules.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "acquire/kinect1/kinect1_camera.h"
#include "acquire/usb/quirks.h"
#include "acquire/usb/usb_numbers.h"

namespace scanknit {
namespace {

constexpr std::string_view kHead = "# Depth cameras, for whoever sits at this computer. Put this into ";

/// Empty: no table has it.
std::string known_name(UsbNumbers numbers) {
  const bool is_kinect = numbers.vendor == kKinect1Vendor && std::ranges::count(kKinect1Products, numbers.product) > 0;
  return is_kinect ? "Kinect v1" : std::string(quirk_of(numbers.vendor, numbers.product).name);
}

/// The number of the package's file: later than the system's own rules, before those that give access.
constexpr std::string_view kFile = "/etc/udev/rules.d/60-scanknit";

std::string common_file() {
  return fmt::format("{}.rules", kFile);
}

std::string file_of(UsbNumbers numbers) {
  return fmt::format("{}-{}-{}.rules", kFile, hex_text(numbers.vendor), hex_text(numbers.product));
}

std::string rule_of(UsbNumbers numbers) {
  const std::string name = known_name(numbers);
  return "# " + (name.empty() ? "A camera that scanknit does not know by name" : name) +
         "\nSUBSYSTEM==\"usb\", ATTR{idVendor}==\"" + hex_text(numbers.vendor) + "\", ATTR{idProduct}==\"" +
         hex_text(numbers.product) + "\", MODE=\"0660\", TAG+=\"uaccess\"\n";
}

}  // namespace

std::string udev_rules() {
  std::string rules = std::string(kHead) + common_file() + "\n";
  for (const CameraQuirk& camera : known_cameras()) rules += rule_of({camera.vendor, camera.product});
  for (const std::uint16_t product : kKinect1Products) rules += rule_of({kKinect1Vendor, product});
  return rules;
}

Result<std::string> udev_rules_for(const std::string& device) {
  constexpr std::string_view kUsb = "usb:";
  std::string_view text = device;
  if (text.starts_with(kUsb)) text.remove_prefix(kUsb.size());
  const auto numbers = parse_usb_numbers(text.substr(0, text.find('/')));
  if (!numbers) {
    return Error{ErrorCode::kUsage, "'" + device +
                                        "' names no USB device; expected vendor and product such as 8086:0b07, as "
                                        "lsusb lists them, or usb:8086:0b07"};
  }
  return std::string(kHead) + file_of(*numbers) + "\n" + rule_of(*numbers);
}

std::string rules_command(std::uint16_t vendor, std::uint16_t product) {
  const UsbNumbers numbers{vendor, product};
  const bool is_known = !known_name(numbers).empty();
  const std::string which = is_known ? "" : " --device " + hex_text(vendor) + ":" + hex_text(product);
  return "scanknit udev-rules" + which + " | sudo tee " + (is_known ? common_file() : file_of(numbers)) +
         " && sudo udevadm control --reload";
}

}  // namespace scanknit
