// SurfacePyramid: a depth frame or a model view as registration reads it, at three resolutions.
#pragma once

#include <vector>

#include "core/camera.h"
#include "core/frame.h"
#include "core/noise_model.h"
#include "fusion/track/model_view.h"

namespace scanknit {

inline constexpr int kPyramidLevels = 3;

/// One plane for each number, rows padded to `stride` (a multiple of kPixelGroup) with zeros, as vector instructions
/// want it, and kPixelGroup numbers more.
struct SurfaceLevel {
  explicit SurfaceLevel(const CameraIntrinsics& intrinsics);

  CameraIntrinsics intrinsics;
  int stride;
  std::vector<float> z_m;         ///< 0: no surface
  std::vector<float> nx, ny, nz;  ///< unit normal, camera frame, towards the camera
  std::vector<float> intensity;   ///< 0 to 1; negative: unknown
  std::vector<float> gx, gy;      ///< intensity's gradient a pixel; 0 where a neighbour is unknown

  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(stride) + static_cast<std::size_t>(x);
  }
};

/// Pixels with a surface.
[[nodiscard]] std::size_t points_of(const SurfaceLevel& level);
/// Of those pixels; 0 when there are none.
[[nodiscard]] double median_depth_m(const SurfaceLevel& level);

/// Level 0 is the finest.
struct SurfacePyramid {
  std::vector<SurfaceLevel> levels;
};

/// The camera of level 0 for frames of this depth camera: halved until it is at most 400 pixels wide, so that
/// 640 x 480 becomes 320 x 240. Model views are rendered with it.
[[nodiscard]] CameraIntrinsics tracking_camera(const CameraIntrinsics& depth_camera);

/// `frame` with its normals; pixels without one face the camera. Colour is looked up through the colour camera. A
/// coarse pixel is the mean plane of those of its 2 x 2 finer pixels that show its nearest surface.
[[nodiscard]] SurfacePyramid pyramid_of(const Frame& frame, const NoiseModel& noise);
[[nodiscard]] SurfacePyramid pyramid_of(const ModelView& view, const NoiseModel& noise);

}  // namespace scanknit
