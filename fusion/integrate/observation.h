// Observation: one frame in the form that integration uses.
#pragma once

#include <cstdint>
#include <optional>

#include "core/camera.h"
#include "core/frame.h"
#include "core/image.h"
#include "fusion/fusion_config.h"
#include "fusion/integrate/depth_pyramid.h"
#include "fusion/integrate/update_block.h"

namespace scanknit {

class Observation {
 public:
  Observation(const Frame& frame, const FusionConfig& config);

  /// The observation of each pixel; valid during the lifetime of this object.
  [[nodiscard]] const Image<PixelPlane>& planes() const { return planes_; }
  [[nodiscard]] const CameraIntrinsics& intrinsics() const { return intrinsics_; }

  /// Per pixel, the z-range in which the truncation band lies along its ray.
  [[nodiscard]] const DepthPyramid& bands() const { return bands_; }

  /// For each pixel, the z up to which its ray certainly passes only free space: in front of the band, and of the
  /// noise, of every pixel within two pixels. 0 next to a pixel without a return, which may hide a surface: rims often
  /// have no return. Empty without carving.
  [[nodiscard]] const Image<float>& clear_m() const { return clear_m_; }

  /// The frame's colours, valid during the lifetime of this object; without pixels if it has none. `number`: the
  /// frame's number.
  [[nodiscard]] ColourView colours(std::uint32_t number) const;

 private:
  void prepare_planes(const Frame& frame, const FusionConfig& config);
  void prepare_clearance(const Image<float>& z_m, const DepthRanges& bands, const NoiseModel& noise);
  void prepare_colour(const ColourFrame& colour);

  CameraIntrinsics intrinsics_;
  Image<PixelPlane> planes_;
  DepthPyramid bands_;
  Image<float> clear_m_;
  std::optional<CameraIntrinsics> colour_camera_;
  Image<std::uint32_t> colours_;
  Pose T_colour_depth_ = Pose::Identity();
};

}  // namespace scanknit
