// SurfaceImage: the surface that a depth frame shows, one small plane at every pixel.
#pragma once

#include <Eigen/Core>

#include "core/frame.h"
#include "core/image.h"
#include "core/noise_model.h"

namespace scanknit {

struct SurfaceImage {
  Image<float> z_m;                ///< where the pixel's ray meets its plane; 0: nothing seen
  Image<Eigen::Vector3f> normals;  ///< of the plane, unit, towards the camera; undefined where nothing is seen

  /// The plane at a pixel is that of the frame's normal, or faces the camera where there is none, at the weighted mean
  /// offset of the 3 x 3 pixels round it that show the same surface: noise falls to a third, edges stay. Pixels without
  /// a return between two that show one surface get the plane between them.
  SurfaceImage(const Frame& frame, const NoiseModel& noise);
};

}  // namespace scanknit
