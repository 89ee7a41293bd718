// The points of a PCD file, through PCL once our own check of the header passed.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "acquire/pcl/pcd_header.h"
#include "core/image.h"
#include "core/pose.h"
#include "core/result.h"

namespace scanknit {

/// In the file's order.
struct PcdPoints {
  PcdHeader header;
  std::vector<Eigen::Vector3f> points_m;  ///< as they are: NaN where there was no return
  std::vector<Eigen::Vector3f> normals;   ///< empty, or one a point, as they are
  std::vector<Rgb8> colours;              ///< empty, or one a point
};

/// Errors (kInput): parse_pcd_header()'s; no x, y, z as 4-byte floats; PCL refuses the body. kInternal: the module for
/// PCL is missing (acquire/pcl/acquire_pcl.h).
[[nodiscard]] Result<PcdPoints> parse_pcd_points(std::span<const std::byte> bytes, const Limits& limits);

/// VIEWPOINT as a pose. Error (kInput): it is not rigid.
[[nodiscard]] Result<Pose> viewpoint_pose(const PcdHeader& header);

}  // namespace scanknit
