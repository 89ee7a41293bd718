// Poses as the KITTI odometry benchmark writes them (Geiger, Lenz, Urtasun 2012).
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "core/pose.h"
#include "core/result.h"

namespace scanknit {

/// A 3x4 matrix, row by row. Errors (kInput, without `where`): not twelve numbers; not rigid.
[[nodiscard]] Result<Pose> kitti_pose(std::span<const std::string_view> words);

/// T_world_camera, a 3x4 matrix a line; a line that is no pose is an Error.
[[nodiscard]] std::vector<Result<Pose>> parse_kitti_poses(std::string_view text);

}  // namespace scanknit
