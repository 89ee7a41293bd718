// Rules for udev: they give the user who is logged in at the computer access to a scanner, and nobody else.
#pragma once

#include <cstdint>
#include <string>

#include "core/result.h"

namespace scanknit {

/// The rules for every scanner in our tables.
[[nodiscard]] std::string udev_rules();

/// The rules for one camera, known or not: "1234:5678" or its URI. Error (kUsage): `device` is no USB device.
[[nodiscard]] Result<std::string> udev_rules_for(const std::string& device);

/// The command with which the user gets access. It writes the rules to a separate file, so that they do not replace
/// another camera's rules. The camera must then be plugged in again.
[[nodiscard]] std::string rules_command(std::uint16_t vendor, std::uint16_t product);

}  // namespace scanknit
