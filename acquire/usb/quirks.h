// The table of UVC depth cameras: properties that their descriptors do not have.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace scanknit {

/// How a camera's calibration is read.
enum class CalibrationReader { kNone, kRealsense };

/// A new camera is one row, and a reader if it has calibration of its own.
struct CameraQuirk {
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
  std::string_view name;
  double depth_unit_m = 0.001;         ///< metres of one raw unit
  std::uint32_t ticks_per_second = 0;  ///< of the time stamps; 0: the descriptors' value
  CalibrationReader calibration = CalibrationReader::kNone;
  std::string_view support = "should work";  ///< docs/devices.md explains the words
};

/// The camera's row; a row without vendor for a camera that is not in the table.
[[nodiscard]] CameraQuirk quirk_of(std::uint16_t vendor, std::uint16_t product);

/// The whole table.
[[nodiscard]] std::span<const CameraQuirk> known_cameras();

}  // namespace scanknit
