// Reads camera files: 3x3 text matrices and Open3D's JSON.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "core/camera.h"
#include "core/limits.h"
#include "core/result.h"

namespace scanknit {

/// A 3x3 matrix of nine numbers, row by row: fx 0 cx / 0 fy cy / 0 0 1. Width and height stay 0.
[[nodiscard]] Result<CameraIntrinsics> parse_camera_matrix(std::string_view text);

/// Open3D's PinholeCameraIntrinsic: width, height, intrinsic_matrix (nine numbers, column by column).
[[nodiscard]] Result<CameraIntrinsics> parse_camera_json(std::string_view text);

/// The camera file in `folder`, else in the folder above: intrinsics.K.txt, camera-intrinsics.txt,
/// camera_intrinsics.txt, intrinsics.txt or camera_intrinsic.json. Nothing when there is none; an error (kInput) when
/// there is one that cannot be read.
[[nodiscard]] Result<std::optional<CameraIntrinsics>> find_camera(const std::filesystem::path& folder,
                                                                  const Limits& limits);

/// The key "depth_scale" of camera_intrinsic.json in `folder` (raw units per metre, 1 to 10,000,000), which our writers
/// add and Open3D ignores. Nothing when it is missing. Errors (kInput): the file cannot be read.
[[nodiscard]] Result<std::optional<double>> find_depth_scale(const std::filesystem::path& folder, const Limits& limits);

/// The error for a missing camera; it says how to give one.
[[nodiscard]] Error missing_camera(const std::filesystem::path& folder);

}  // namespace scanknit
