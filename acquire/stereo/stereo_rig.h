// StereoRig: two cameras of one rig, as its files state them. Private to the room.
#pragma once

#include <filesystem>
#include <optional>

#include "acquire/replay/folder.h"
#include "acquire/replay/undistort.h"
#include "core/camera.h"
#include "core/pose.h"
#include "core/result.h"

namespace scanknit {

struct StereoCamera {
  CameraIntrinsics intrinsics;  ///< width and height 0: the size of the picture
  RationalDistortion distortion{};
};

struct StereoRig {
  StereoCamera left = {}, right = {};
  Pose T_right_left = Pose::Identity();  ///< of a usable rig, x of its translation is below 0
  std::filesystem::path file = {};       ///< that states it

  /// True if a point has the same row in both pictures, as they are. Only their cx may differ.
  [[nodiscard]] bool is_rectified() const {
    constexpr double kTurn = 1e-9;
    const CameraIntrinsics& a = left.intrinsics;
    const CameraIntrinsics& b = right.intrinsics;
    const Eigen::Vector3d t = T_right_left.translation();
    return left.distortion == RationalDistortion{} && right.distortion == RationalDistortion{} && a.fx == b.fx &&
           a.fy == b.fy && a.cy == b.cy && t.y() == 0 && t.z() == 0 &&
           T_right_left.linear().isApprox(Eigen::Matrix3d::Identity(), kTurn);
  }
  [[nodiscard]] double baseline_m() const { return T_right_left.translation().norm(); }
};

/// The folders of the two pictures, by a known pair of names: left and right, image_0 and image_1, ...
struct StereoFolders {
  Folder recording;
  std::filesystem::path left, right;
  int kitti_left = 0;     ///< image_0 and image_1 have P0 and P1, image_2 and image_3 P2 and P3
  bool is_euroc = false;  ///< cam0/data and cam1/data, each with a sensor.yaml beside it
};

/// In `path`, or in `path`/mav0. Nothing: no pair of folders has such names.
[[nodiscard]] std::optional<StereoFolders> find_stereo_folders(const std::filesystem::path& path, const Limits& limits);

/// From stereo.yaml, OpenCV's, Kalibr's, KITTI's or EuRoC's files (docs/stereo.md). Errors (kInput) name the file: none
/// is there, keys are missing, no camera, no baseline, or a kind of lens that is not known.
[[nodiscard]] Result<StereoRig> read_stereo_rig(const StereoFolders& folders, const Limits& limits);

}  // namespace scanknit
