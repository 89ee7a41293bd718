#include "acquire/usb/quirks.h"

#include <algorithm>

namespace scanknit {
namespace {

constexpr std::uint16_t kIntel = 0x8086;
// RealSense counts microseconds in its time stamps, whatever clock its descriptors name (librealsense,
// src/uvc-sensor.cpp).
constexpr std::uint32_t kMicroseconds = 1'000'000;

constexpr CameraQuirk realsense(std::uint16_t product, std::string_view name, double unit_m = 0.001) {
  return {kIntel, product, name, unit_m, kMicroseconds, CalibrationReader::kRealsense};
}

// Product numbers after librealsense (Apache-2.0), src/ds/d400/d400-private.h.
constexpr CameraQuirk kCameras[] = {
    {kIntel, 0x0b07, "Intel RealSense D435", 0.001, kMicroseconds, CalibrationReader::kRealsense,
     "tested on an emulated device"},
    realsense(0x0ad1, "Intel RealSense D400"),
    realsense(0x0ad2, "Intel RealSense D410"),
    realsense(0x0ad3, "Intel RealSense D415"),
    realsense(0x0ad4, "Intel RealSense D430"),
    realsense(0x0b3a, "Intel RealSense D435i"),
    realsense(0x0b5b, "Intel RealSense D405", 0.0001),
    realsense(0x0b5c, "Intel RealSense D455"),
    realsense(0x1155, "Intel RealSense D421"),
};

}  // namespace

CameraQuirk quirk_of(std::uint16_t vendor, std::uint16_t product) {
  for (const CameraQuirk& camera : kCameras) {
    if (camera.vendor == vendor && camera.product == product) return camera;
  }
  return {};
}

std::span<const CameraQuirk> known_cameras() {
  return kCameras;
}

}  // namespace scanknit
