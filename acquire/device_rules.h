// Rules for udev: who may use a scanner. They let whoever sits at the computer use it, and nobody else.
#pragma once

#include <cstdint>
#include <string>

#include "core/result.h"

namespace scanknit {

/// For every scanner that our tables know.
[[nodiscard]] std::string udev_rules();

/// For one camera, known or not: "1234:5678" or its URI. Error (kUsage): it names no USB device.
[[nodiscard]] Result<std::string> udev_rules_for(const std::string& device);

/// What a person types to be let in: the rules into a file of their own, so that they take no other camera's away. It
/// then needs to be plugged in again.
[[nodiscard]] std::string rules_command(std::uint16_t vendor, std::uint16_t product);

}  // namespace scanknit
