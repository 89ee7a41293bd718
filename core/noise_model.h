// NoiseModel: the axial noise of a structured-light depth camera.
#pragma once

namespace scanknit {

/// sigma(z) = floor + growth (z - from)^2, metres. Nguyen, Izadi, Lovell 2012, "Modeling Kinect Sensor Noise for
/// Improved 3D Reconstruction and Tracking", equation (1); the defaults are theirs for a Kinect seen nearly head-on.
struct NoiseModel {
  double floor_m = 0.0012;
  double growth_per_m = 0.0019;
  double from_m = 0.4;

  [[nodiscard]] double sigma_m(double z_m) const {
    const double beyond = z_m - from_m;
    return floor_m + growth_per_m * beyond * beyond;
  }
  /// sigma(z) times `scale`.
  [[nodiscard]] NoiseModel scaled(double scale) const { return {floor_m * scale, growth_per_m * scale, from_m}; }
};

}  // namespace scanknit
