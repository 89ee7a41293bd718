// A trajectory's file: in the TUM format, KITTI's, or JSON.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/pose.h"

namespace scanknit {

/// Where a camera was at one moment.
struct StampedPose {
  double stamp;  ///< seconds of the recording's clock, or the frame's number where it has none
  Pose T_world_camera;
};

/// TUM format: "stamp tx ty tz qx qy qz qw", one line a pose, with enough digits to restore the pose within 1e-9.
[[nodiscard]] std::string to_tum_trajectory(const std::vector<StampedPose>& poses);

/// KITTI's odometry format: the upper three rows of T_world_camera, one line a pose; it has no stamps.
[[nodiscard]] std::string to_kitti_trajectory(const std::vector<StampedPose>& poses);

/// {"note": ..., "poses": [{"stamp": ..., "T_world_camera": four rows}, ...]}; without a note if that is empty.
[[nodiscard]] std::string to_json_trajectory(const std::vector<StampedPose>& poses, std::string_view note = {});

/// By the path's ending: `.kitti`, `.json`, else TUM's, with the note as its first line ("# note").
[[nodiscard]] std::string trajectory_text(const std::filesystem::path& path, const std::vector<StampedPose>& poses,
                                          std::string_view note = {});

}  // namespace scanknit
