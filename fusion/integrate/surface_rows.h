// The two passes over a depth frame that come before integration, sixteen pixels at a time.
#pragma once

#include <Eigen/Core>
#include <span>

#include "core/camera.h"
#include "core/pixels/pixel_rows.h"
#include "fusion/fusion_config.h"
#include "fusion/integrate/depth_pyramid.h"
#include "fusion/integrate/surface_image.h"
#include "fusion/integrate/update_block.h"

namespace scanknit {

/// Rays through pixel centres, z = 1.
struct Rays {
  float per_fx, per_fy, cx, cy;
  explicit Rays(const CameraIntrinsics& k)
      : per_fx(static_cast<float>(1 / k.fx)),
        per_fy(static_cast<float>(1 / k.fy)),
        cx(static_cast<float>(k.cx)),
        cy(static_cast<float>(k.cy)) {}
  [[nodiscard]] Eigen::Vector3f at(int x, int y) const {
    return {(static_cast<float>(x) - cx) * per_fx, (static_cast<float>(y) - cy) * per_fy, 1};
  }
};

/// Two pixels of one surface differ by sqrt(2) sigma; if they differ by more than three times that, they show different
/// surfaces.
inline constexpr float kSameSurfaceSigmas = 4.25f;

/// At more grazing angles, a surface's offset determines its depth badly.
inline constexpr float kMinSmoothedSlope = 0.1f;

/// The band of a slanted surface is longer along the ray than across it, up to this slope.
inline constexpr float kMinBandSlope = 0.25f;

/// Whole rows of one width; pixel x of a row at [x].
struct DepthRows {
  const float* above;
  const float* own;
  const float* below;
  const Eigen::Vector3f* normals;  ///< of `own`; null: every plane faces the camera
  int width;
};

/// Fills the pixels 1 to width - 2 of row y that have a return: see SurfaceImage. width >= kPixelGroup + 2.
void smooth_row(const DepthRows& rows, int y, const Rays& rays, const FloatNoise& noise, float* z_m,
                Eigen::Vector3f* normals);

/// The parameters that turn planes into observations.
struct Band {
  float least_m;  ///< half-width of the truncation band
  float sigmas;   ///< and in standard deviations of the noise
  FloatNoise noise;
  float best_variance;  ///< least variance of the noise: an observation with it, at a right angle, has the weight 1
};

/// Fills row y of both: the z-range of the truncation band along each ray, and the planes for integration.
void band_row(std::span<const float> z_m, const Eigen::Vector3f* normals, int y, const Rays& rays, const Band& band,
              DepthRanges& ranges, PixelPlane* planes);

}  // namespace scanknit
