// Pictures, cameras and poses as the files that the recording layouts share.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "core/camera.h"
#include "core/image.h"
#include "core/pose.h"
#include "core/result.h"

namespace scanknit {

/// Metres as 16 bits with `units_per_metre`, rounded to the nearest. 0: no return, or more than 65534 units.
[[nodiscard]] Image<std::uint16_t> to_raw_depth(const DepthImage& depth_m, double units_per_metre);

// Each write is atomic. Errors: kOutput.

[[nodiscard]] Result<void> write_bytes(std::span<const std::byte> bytes, const std::filesystem::path& path);
[[nodiscard]] Result<void> write_depth_png(const Image<std::uint16_t>& raw, const std::filesystem::path& path);
[[nodiscard]] Result<void> write_colour_png(const ColourImage& colour, const std::filesystem::path& path);
[[nodiscard]] Result<void> write_colour_jpeg(const ColourImage& colour, const std::filesystem::path& path);

/// Open3D's camera_intrinsic.json, with one more key, "depth_scale": raw units per metre.
[[nodiscard]] Result<void> write_camera_json(const CameraIntrinsics& camera, double units_per_metre,
                                             const std::filesystem::path& path);

/// Appends four lines, row by row, with all digits of a double.
void append_matrix(std::string& text, const Eigen::Matrix4d& matrix);

/// Appends the five lines of one pose of Open3D's trajectory.log.
void append_log_pose(std::string& log, std::size_t frame, const Eigen::Matrix4d& T_world_camera);

}  // namespace scanknit
