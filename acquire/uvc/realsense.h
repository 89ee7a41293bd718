// The extension unit of a RealSense camera: calibration and controls.
#pragma once

#include <cstdint>
#include <span>

#include "acquire/raw_frame.h"
#include "acquire/usb/realsense_tables.h"
#include "acquire/usb/usb_context.h"
#include "acquire/uvc/uvc_descriptors.h"
#include "core/result.h"

namespace scanknit {

/// Numbers of the extension unit's controls (librealsense, src/ds/ds-private.h).
enum class RealsenseControl : std::uint8_t {
  kHardwareMonitor = 0x01,
  kEmitter = 0x02,
  kLaserPower = 0x04,
  kPreset = 0x06,
  kAutoExposure = 0x0B,
};

/// The extension unit of an open camera whose control interface is claimed. For one thread.
class RealsenseUnit {
 public:
  RealsenseUnit(UsbHandle& device, const UvcFunction& function, std::uint8_t unit)
      : device_(device), control_interface_(function.control_interface), unit_(unit) {}

  /// Errors (kDevice): refused, no answer, an invalid answer.
  [[nodiscard]] Result<RealsenseIdentity> identity();
  [[nodiscard]] Result<CameraIntrinsics> depth_camera(int width, int height);
  /// Of a pair of infrared pictures: metres.
  [[nodiscard]] Result<double> baseline_m();
  [[nodiscard]] Result<RealsenseColour> colour_camera(int width, int height);
  /// Metres. Also an error unless the camera's advanced mode is on.
  [[nodiscard]] Result<double> depth_unit_m();
  [[nodiscard]] Result<void> set(RealsenseControl control, int value);

 private:
  [[nodiscard]] Result<std::vector<std::byte>> ask(RealsenseOpcode opcode, std::uint32_t parameter);
  [[nodiscard]] Result<std::uint16_t> length_of(RealsenseControl control);
  [[nodiscard]] std::uint16_t index() const { return static_cast<std::uint16_t>(unit_ << 8 | control_interface_); }

  UsbHandle& device_;
  std::uint8_t control_interface_;
  std::uint8_t unit_;
};

/// The number of RealSense's extension unit in a video function, or 0.
[[nodiscard]] std::uint8_t realsense_unit_of(const UvcFunction& function);

}  // namespace scanknit
