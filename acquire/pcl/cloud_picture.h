// The depth picture that an organised point cloud is, and the camera that its points tell of.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/camera.h"
#include "core/image.h"

namespace scanknit {

struct CloudPicture {
  DepthImage depth_m;                      ///< z of each point; 0 where it is not finite or not positive
  std::optional<CameraIntrinsics> camera;  ///< nothing: the points are too few, or not those of a pinhole camera
  bool has_enough_points = false;          ///< to tell which of these it is
};

/// `points_m`: width x height of them, row by row. The camera is the line of pixel against slope (x/z, y/z) with least
/// squares; points that miss their pixels by more than one on average have none.
[[nodiscard]] CloudPicture picture_of_cloud(int width, int height, const std::vector<Eigen::Vector3f>& points_m);

}  // namespace scanknit
