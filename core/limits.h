// Limits: the largest accepted inputs. Sizes from a file are checked against them before any allocation.
#pragma once

#include <cstddef>
#include <cstdint>

namespace scanknit {

struct Limits {
  std::int64_t max_image_pixels = 64'000'000;      ///< 8000 x 8000: ten times any depth camera's colour picture
  std::uintmax_t max_image_bytes = 256u << 20;     ///< one encoded picture
  std::uintmax_t max_text_bytes = 64u << 20;       ///< one text file of a recording: a million lines of a trajectory
  std::uintmax_t max_mesh_bytes = 4096ull << 20;   ///< one mesh file
  std::uintmax_t max_range_bytes = 1024ull << 20;  ///< one range scan or point cloud, unpacked
  std::size_t max_scans = 1000;                    ///< scans in one file
  std::size_t max_frames = 10'000'000;             ///< 90 hours at 30 frames a second
  std::size_t max_mesh_vertices = 1u << 30;
  std::size_t max_mesh_triangles = 1u << 30;
  std::uintmax_t max_config_bytes = 64u << 10;
};

}  // namespace scanknit
