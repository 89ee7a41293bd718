// The readers of LiDAR sweeps, and their grids; the first byte chooses one.
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "acquire/lidar/kitti.h"
#include "acquire/lidar/sweep_grid.h"
#include "acquire/parse/kitti_poses.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  if (size == 0) return 0;
  const auto content = std::as_bytes(std::span(bytes, size)).subspan(1);
  const std::string_view text(reinterpret_cast<const char*>(bytes) + 1, size - 1);
  switch (bytes[0] % 3) {
    case 0:
      if (auto points = scanknit::parse_kitti_points(content)) {
        (void)scanknit::grid_of({.points_m = *std::move(points)}, {0.5, 50});
      }
      break;
    case 1: (void)scanknit::parse_kitti_calibration(text); break;
    default: (void)scanknit::parse_kitti_poses(text); break;
  }
  return 0;
}
