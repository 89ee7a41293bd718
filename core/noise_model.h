// NoiseModel: the axial noise of a depth camera.
#pragma once

#include <cmath>
#include <limits>
#include <optional>

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
  /// The distance beyond which sigma(z) exceeds `sigma_m`, which is at least the floor; infinity where it never does.
  [[nodiscard]] double reach_m(double sigma_m) const {
    if (!(growth_per_m > 0)) return std::numeric_limits<double>::infinity();
    return from_m + std::sqrt((sigma_m - floor_m) / growth_per_m);
  }
  /// sigma(z) times `scale`.
  [[nodiscard]] NoiseModel scaled(double scale) const { return {floor_m * scale, growth_per_m * scale, from_m}; }

  friend bool operator==(const NoiseModel&, const NoiseModel&) = default;
};

/// What is given of a sensor's noise; nothing: as the sensor has it.
struct GivenNoise {
  std::optional<double> floor_m, growth_per_m, from_m;

  [[nodiscard]] NoiseModel over(const NoiseModel& sensor) const {
    return {floor_m.value_or(sensor.floor_m), growth_per_m.value_or(sensor.growth_per_m),
            from_m.value_or(sensor.from_m)};
  }
};

}  // namespace scanknit
