// The inner loops of deskew(): rows of pictures that a rolling shutter took, sixteen pixels at a time.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "core/camera.h"
#include "core/frame_timing.h"

namespace scanknit {

/// How points move through a picture while its rows are read.
struct RowFlow {
  int width, height;
  float fx, fy, cx, cy, per_fx, per_fy;
  Eigen::Vector3f turn, shift;  ///< of the camera, from the first row to the last

  RowFlow(const CameraIntrinsics& camera, const SteadyMotion& rows);
};

/// The pose of a row in the axes of the middle row: three rows of the rotation, each with its part of the translation.
using RowPose = Eigen::Matrix<float, 3, 4, Eigen::RowMajor>;

/// A depth picture as it was read.
struct SeenSurface {
  const float* z_m;                ///< metres; 0: none
  const Eigen::Vector3f* normals;  ///< null: none
  const RowPose* T_middle_row;     ///< one a row
  float typical_m;                 ///< depth that is assumed where there is none
  float least_step;                ///< a difference of 1 / z that moves a pixel's place
};

/// Row y of the picture that is read at once at the time of the middle row. Writes a multiple of kPixelGroup; `normals`
/// is null if the surface has none. Where nothing was seen, depth and normal are 0.
void deskew_row(const RowFlow& flow, const SeenSurface& seen, int y, float* z_m, Eigen::Vector3f* normals);

/// For each pixel of row y, the number of the pixel, row by row, that saw what it shows, if that is at depth 1 / per_z;
/// -1: outside of the picture. Writes a multiple of kPixelGroup.
void find_places(const RowFlow& flow, float per_z, int y, std::int32_t* places);

}  // namespace scanknit
