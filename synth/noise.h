// Kinect-like noise: turns exact depth into the depth that a structured-light camera would report.
#pragma once

#include <cstdint>

#include "core/camera.h"
#include "core/image.h"
#include "core/noise_model.h"

namespace scanknit {

/// The axial deviation sigma(z) was measured on a real sensor, so it includes the error of the disparity's steps. The
/// Gaussian part is the rest, sqrt(sigma^2 - step^2 / 12), so that the total follows `axial`.
struct KinectNoise {
  NoiseModel axial;
  double baseline_m = 0.075;
  double sensor_focal_px = 580;        ///< of the sensor's infrared camera, independent of the rendered camera
  double disparity_step_px = 1.0 / 8;  ///< steps of 26 mm at 3 m; 0: no quantisation
  double edge_dropout = 0.5;           ///< probability that a pixel beside a depth step has no return
  double flying_pixel = 0.05;          ///< probability that such a pixel gets a depth between the two
  double grazing_begin_rad = 1.309;    ///< 75 degrees of incidence: dropouts begin here ...
  double grazing_end_rad = 1.484;      ///< ... and are certain here, at 85 degrees
  double min_depth_m = 0.4;
  double max_depth_m = 5.0;
};

/// A pure function of its arguments, the same for any number of threads. `cos_incidence` has the size of `depth_m`.
[[nodiscard]] DepthImage add_kinect_noise(const DepthImage& depth_m, const Image<float>& cos_incidence,
                                          const CameraIntrinsics& intrinsics, const KinectNoise& noise,
                                          std::uint64_t seed, std::uint64_t frame);

}  // namespace scanknit
