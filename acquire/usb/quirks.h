// The table of UVC depth cameras: what their descriptors do not say.
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
  std::uint32_t ticks_per_second = 0;  ///< of the time stamps; 0: as the descriptors say
  CalibrationReader calibration = CalibrationReader::kNone;
  std::string_view support = "should work";  ///< docs/devices.md says what the words mean
};

/// The camera's row, or one without vendor for a camera that is not in the table.
[[nodiscard]] CameraQuirk quirk_of(std::uint16_t vendor, std::uint16_t product);

/// The whole table.
[[nodiscard]] std::span<const CameraQuirk> known_cameras();

}  // namespace scanknit
