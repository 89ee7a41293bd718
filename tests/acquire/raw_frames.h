// Raw frames that tests make for themselves.
#pragma once

#include <cstdint>
#include <memory>
#include <random>
#include <vector>

#include "acquire/raw_frame.h"

namespace scanknit::test {

inline constexpr std::int64_t kPeriod_ns = 33'333'333;

[[nodiscard]] inline std::shared_ptr<const std::vector<std::byte>> share(std::vector<std::byte> bytes) {
  return std::make_shared<const std::vector<std::byte>>(std::move(bytes));
}

/// A slanted plane with a hole and noise: what depth pictures are like. The same for the same number.
[[nodiscard]] inline std::vector<std::byte> depth_bytes(int width, int height, std::uint32_t number) {
  std::minstd_rand random(number + 1);
  std::vector<std::byte> bytes;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const bool is_hole = (x / 16 + y / 16 + static_cast<int>(number)) % 7 == 0;
      const unsigned raw = is_hole ? 0
                                   : 800u + static_cast<unsigned>(x) + 2u * static_cast<unsigned>(y) +
                                         static_cast<unsigned>(random() % 4);
      bytes.push_back(static_cast<std::byte>(raw & 0xFF));
      bytes.push_back(static_cast<std::byte>(raw >> 8 & 0xFF));
    }
  }
  return bytes;
}

[[nodiscard]] inline RawFrame depth_frame(std::uint32_t number, int width = 64, int height = 48) {
  RawFrame frame;
  frame.profile = {StreamKind::kDepth, PixelFormat::kZ16, width, height, 30};
  frame.sequence = number;
  frame.device_ns = 5'000'000'000 + number * kPeriod_ns;
  frame.host_ns = 9'000'000'000 + number * kPeriod_ns + 4'000'000;
  frame.bytes = share(depth_bytes(width, height, number));
  return frame;
}

/// RGB that counts upwards, `late_ns` after the depth picture of this number.
[[nodiscard]] inline RawFrame colour_frame(std::uint32_t number, std::int64_t late_ns = 1'000'000, int width = 32,
                                           int height = 24) {
  RawFrame frame;
  frame.profile = {StreamKind::kColour, PixelFormat::kRgb8, width, height, 30};
  frame.sequence = number;
  frame.device_ns = 5'000'000'000 + number * kPeriod_ns + late_ns;
  frame.host_ns = frame.device_ns + 4'000'000'000;
  std::vector<std::byte> bytes(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::byte>((i + 7 * number) & 0xFF);
  frame.bytes = share(std::move(bytes));
  return frame;
}

/// Of depth_frame and colour_frame.
[[nodiscard]] inline RawCalibration raw_calibration(int width = 64, int height = 48) {
  RawCalibration calibration;
  calibration.depth.intrinsics = {width, height, 60.25, 60.5, 31.5, 23.5};
  calibration.colour.intrinsics = {32, 24, 30.125, 30.25, 15.5, 11.5};
  calibration.T_colour_depth.translation() = Eigen::Vector3d(0.015, 0.1 / 3, -1e-3);
  calibration.T_colour_depth.rotate(Eigen::AngleAxisd(0.02, Eigen::Vector3d(1, 2, 3).normalized()));
  calibration.source = "the test's";
  calibration.device = "pretended camera";
  calibration.serial = "0001";
  return calibration;
}

}  // namespace scanknit::test
