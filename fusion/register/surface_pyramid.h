// SurfacePyramid: a depth frame or a model view at three resolutions, in the form that registration uses.
#pragma once

#include <vector>

#include "core/camera.h"
#include "core/frame.h"
#include "core/frame_timing.h"
#include "core/noise_model.h"
#include "fusion/register/model_view.h"

namespace scanknit {

inline constexpr int kPyramidLevels = 3;

/// One array for each number. For vector instructions, rows are padded with zeros to `stride` (a multiple of
/// kPixelGroup), and kPixelGroup numbers follow the last row.
struct SurfaceLevel {
  explicit SurfaceLevel(const CameraIntrinsics& intrinsics);

  CameraIntrinsics intrinsics;
  int stride;
  std::vector<float> z_m;         ///< 0: no surface
  std::vector<float> nx, ny, nz;  ///< unit normal, camera frame, towards the camera
  std::vector<float> intensity;   ///< 0 to 1; negative: unknown
  std::vector<float> gx, gy;      ///< gradient of intensity for each pixel; 0 if a neighbour is unknown

  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(stride) + static_cast<std::size_t>(x);
  }
};

/// The number of pixels with a surface.
[[nodiscard]] std::size_t points_of(const SurfaceLevel& level);
/// The median depth of those pixels; 0 when there are none.
[[nodiscard]] double median_depth_m(const SurfaceLevel& level);

/// Level 0 is the finest.
struct SurfacePyramid {
  std::vector<SurfaceLevel> levels;
};

/// The camera of level 0 for frames of this depth camera: halved until it is at most 400 pixels wide, so that
/// 640 x 480 becomes 320 x 240. Model views are rendered with it.
[[nodiscard]] CameraIntrinsics tracking_camera(const CameraIntrinsics& depth_camera);

/// Uses the normals of `frame`; pixels without one face the camera. Reads colour through the colour camera, which has
/// moved by `to_colour` since depth was taken. A coarse pixel is the mean plane of those of its 2 x 2 finer pixels that
/// show the nearest surface.
[[nodiscard]] SurfacePyramid pyramid_of(const Frame& frame, const NoiseModel& noise,
                                        const SteadyMotion& to_colour = {});
[[nodiscard]] SurfacePyramid pyramid_of(const ModelView& view, const NoiseModel& noise);

}  // namespace scanknit
