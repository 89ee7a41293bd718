// Observation: one depth frame as integration reads it. Every pixel is a small plane.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/camera.h"
#include "core/frame.h"
#include "core/image.h"
#include "fusion/depth_pyramid.h"
#include "fusion/fusion_config.h"

namespace scanknit {

/// The tangent plane of the surface at a pixel, camera frame: normal . p = offset_m. The normal is unit and points to
/// the camera. A normal of zero: no return.
struct PixelPlane {
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();
  float offset_m = 0;
};

/// How much a pixel is believed.
struct PixelTrust {
  float weight = 0;        ///< cos(incidence) / sigma^2(z), 1 for a head-on pixel at the sensor's noise floor
  float truncation_m = 0;  ///< half-width of the band: max(n voxels, k sigma(z))
};

/// What a frame says of one point in space.
struct Sighting {
  float distance_m;    ///< signed distance to the surface, positive on the camera's side
  float truncation_m;  ///< of the pixel that was asked
  float weight;        ///< of the pixel that was asked
};

class Observation {
 public:
  Observation(const Frame& frame, const FusionConfig& config);

  /// Nothing when the point is not in the picture, or no pixel beside its projection has a return.
  /// The distance is the mean of the distances to the planes of the up to four pixels round the projection, with
  /// bilinear weights: exact on planes even where some of the four are missing. Pixels of another surface are left out.
  [[nodiscard]] std::optional<Sighting> sight(const Eigen::Vector3f& p_camera) const;

  /// The colour camera's picture at a point (sRGB, 0 to 1), if it is in the picture.
  [[nodiscard]] std::optional<Eigen::Vector3f> colour_at(const Eigen::Vector3f& p_camera) const;

  [[nodiscard]] bool has_colour() const { return colour_ != nullptr; }
  [[nodiscard]] const CameraIntrinsics& intrinsics() const { return intrinsics_; }

  /// Per pixel, the z-range in which the truncation band lies along its ray.
  [[nodiscard]] const DepthPyramid& bands() const { return bands_; }

 private:
  CameraIntrinsics intrinsics_;
  Image<PixelPlane> planes_;
  Image<PixelTrust> trust_;
  DepthPyramid bands_;
  const ColourFrame* colour_ = nullptr;
  Eigen::Matrix3f R_colour_depth_ = Eigen::Matrix3f::Identity();
  Eigen::Vector3f t_colour_depth_ = Eigen::Vector3f::Zero();
};

}  // namespace scanknit
