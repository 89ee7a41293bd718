// The KITTI odometry benchmark (Geiger, Lenz, Urtasun 2012): velodyne/000000.bin, calib.txt, times.txt, poses.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "acquire/lidar/sweep_source.h"
#include "acquire/replay/folder.h"
#include "core/limits.h"
#include "core/pose.h"
#include "core/result.h"

namespace scanknit {

/// The points of a .bin: x y z reflectance, 32-bit floats, little-endian. Points that are not finite, and those at the
/// sensor itself, are left out. Errors (kInput, without `where`): a length that is no whole number of points.
[[nodiscard]] Result<std::vector<Eigen::Vector3f>> parse_kitti_points(std::span<const std::byte> bytes);

/// T_camera_sensor, the line "Tr:" of calib.txt (or "Tr_velo_to_cam:"). Errors (kInput, without `where`): there is
/// none; not a rigid 3x4 matrix.
[[nodiscard]] Result<Pose> parse_kitti_calibration(std::string_view text);

/// True for a folder of a sequence: it has velodyne/ with .bin files in it.
[[nodiscard]] bool fits_kitti(const Folder& folder, const Limits& limits);

/// The world is the frame of the first left camera: x right, y down, z forward. Errors: those of open_sweeps().
[[nodiscard]] Result<std::unique_ptr<SweepSource>> open_kitti(const Folder& folder, const Limits& limits);

}  // namespace scanknit
