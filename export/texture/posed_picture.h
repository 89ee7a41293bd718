// PosedPicture: a frame's colour picture, prepared to look up points of the surface.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "core/frame.h"
#include "core/image.h"
#include "core/pose.h"
#include "export/picture/surface_fit.h"

namespace scanknit {

using LinearColour = std::array<float, 3>;  ///< linear light, 0..1

/// One frame's colour, and its depth from the colour camera's view.
class PosedPicture {
 public:
  /// The frame has colour and outlives this object. `band`: as in fit_surface().
  PosedPicture(const Frame& frame, const Pose& T_world_camera, const FitBand& band);

  [[nodiscard]] const Pose& T_colour_world() const { return T_colour_world_; }

  /// One bit for each reason why a point with this normal is not visible. A reason that all corners share holds for the
  /// whole triangle.
  [[nodiscard]] unsigned out_of_sight(const Eigen::Vector3f& p_colour, const Eigen::Vector3f& normal) const;

  /// A point's position in the picture, and how well it is seen.
  struct Sight {
    float x, y;     ///< pixels of the colour picture
    float quality;  ///< > 0: pixels per unit of the surface's area, less near borders and edges
  };
  /// Nothing if the picture does not show the point: it is outside, faces away, is hidden behind the depth picture's
  /// surface, or is next to a depth step. `normal` need not be unit. Both in the colour camera's frame.
  [[nodiscard]] std::optional<Sight> look_at(const Eigen::Vector3f& p_colour, const Eigen::Vector3f& normal) const;

  /// Bilinear, in linear light.
  [[nodiscard]] LinearColour colour(const Sight& sight) const;

 private:
  void see_depth(const Frame& frame);
  [[nodiscard]] float band_m(float depth_m) const;
  void measure_clearance();
  void fill_small_holes();

  const ColourImage& picture_;
  CameraIntrinsics camera_;        ///< of the picture
  CameraIntrinsics depth_camera_;  ///< the same camera at the resolution of the depth below
  float least_band_m_, sigmas_;
  NoiseModel noise_;
  Pose T_colour_world_;
  Image<float> depth_m_;       ///< seen from the colour camera; 0: unknown
  Image<float> clearance_px_;  ///< distance to the nearest step or unknown depth
};

}  // namespace scanknit
