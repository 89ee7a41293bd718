// SurfaceImage: the surface of a depth frame, one small plane at every pixel.
#pragma once

#include <Eigen/Core>

#include "core/frame.h"
#include "core/image.h"
#include "core/noise_model.h"

namespace scanknit {

struct SurfaceImage {
  Image<float> z_m;                ///< where the pixel's ray meets its plane; 0: no surface
  Image<Eigen::Vector3f> normals;  ///< of the plane, unit, towards the camera; undefined without a surface

  /// The plane at a pixel has the frame's normal, or faces the camera if there is none. Its offset is the weighted mean
  /// of those of the 3 x 3 pixels that show the same surface: this reduces noise to a third and keeps edges. A pixel
  /// without a return between two pixels of one surface gets the plane between them.
  SurfaceImage(const Frame& frame, const NoiseModel& noise);
};

}  // namespace scanknit
