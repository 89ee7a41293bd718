// ModelView: a camera's view of the volume.
#pragma once

#include <Eigen/Core>

#include "core/camera.h"
#include "core/image.h"
#include "core/pose.h"

namespace scanknit {

/// All pictures have the size of `intrinsics`. A pixel without a surface has depth 0, normal zero and no intensity.
struct ModelView {
  CameraIntrinsics intrinsics;
  Pose T_world_camera = Pose::Identity();
  DepthImage depth_m;              ///< z-depth of the nearest surface seen from its front
  Image<Eigen::Vector3f> normals;  ///< camera frame, unit, towards the camera
  Image<float> intensity;          ///< luma of the sRGB colour, 0 to 1; negative: no colour is known
};

}  // namespace scanknit
