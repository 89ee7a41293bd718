// Point features of a picture with depth, and the motion between two such pictures.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/pose.h"
#include "core/result.h"
#include "fusion/register/surface_pyramid.h"

namespace scanknit {

struct Feature {
  std::array<std::uint8_t, 32> descriptor;  ///< compared bit by bit
  Eigen::Vector2f pixel;
  Eigen::Vector3f p_camera;
};

/// Opens the module that finds features, for a scan that is to be tracked. Error (kInternal): load_module()'s.
[[nodiscard]] Result<void> check_features();

/// ORB features (Rublee et al. 2011) at pixels with depth. None without colour, or without the module.
[[nodiscard]] std::vector<Feature> find_features(const SurfaceLevel& picture);

/// T_from_to from the common features of both pictures: P3P in RANSAC, with the same draws in every run. Nothing unless
/// at least a dozen agree.
[[nodiscard]] std::optional<Pose> match_features(const std::vector<Feature>& from, const std::vector<Feature>& to,
                                                 const CameraIntrinsics& to_camera);

}  // namespace scanknit
