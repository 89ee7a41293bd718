// The inner loop of SurfacePyramid: one row of a level from two rows of the finer one, sixteen pixels at a time.
#pragma once

#include <Eigen/Core>

#include "core/pixels/pixel_rows.h"
#include "fusion/integrate/surface_rows.h"

namespace scanknit {

/// A row of planes, as one array for each number; see SurfaceLevel.
template <typename Number>
struct PlaneRow {
  Number* z_m;
  Number *nx, *ny, *nz;
  Number* intensity;  ///< null: unknown everywhere
};

/// Sets pixel x of row y of `coarse` to the mean plane of those of the pixels 2 x and 2 x + 1 of two finer rows, 2 y
/// and 2 y + 1, that are on the nearest surface. `width` pixels; reads and writes a multiple of kPixelGroup.
void shrink_rows(const PlaneRow<const float>& upper, const PlaneRow<const float>& lower, const Rays& fine_rays,
                 const Rays& coarse_rays, const FloatNoise& noise, int width, int y, const PlaneRow<float>& coarse);

/// Fills in a row's normals; null or zero: the pixel's plane faces the camera.
void split_normals(const Eigen::Vector3f* normals, const Rays& rays, int width, int y, float* nx, float* ny, float* nz);

}  // namespace scanknit
