// HandMotion: a path as a hand carries a camera along it.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "synth/path/motion.h"

namespace scanknit {

/// A sum of sines with seeded frequencies and phases: endlessly smooth, never repeating, zero on average.
class Wobble {
 public:
  /// `deviation` is the root mean square of the sum. Frequencies in hertz.
  Wobble(double deviation, double lowest_hz, double highest_hz, std::uint64_t seed, std::uint64_t channel);
  [[nodiscard]] double at(double time_s) const;

 private:
  struct Wave {
    double amplitude, speed_rad_s, phase_rad;
  };
  std::array<Wave, 5> waves_;
};

/// Callable as a Motion. The numbers are our own choice, except the band of tremor: 8 to 12 Hz is that of physiological
/// tremor (Elble and Koller 1990, "Tremor").
class HandMotion {
 public:
  HandMotion(CameraPath path, const MotionConfig& config);
  [[nodiscard]] Pose operator()(double frame) const;

 private:
  /// A look aside: out, a short rest, and back. Each way is a minimum-jerk turn.
  struct Turn {
    double begin_s, angle_rad, way_s, rest_s;
  };
  /// The pace falls to zero within kBraking_s, and rises again after the rest.
  struct Stop {
    double begin_s, rest_s;
  };
  void draw_turns();
  void draw_stops();
  [[nodiscard]] double lost_s(double time_s) const;
  [[nodiscard]] double pace(double time_s) const;
  [[nodiscard]] double yaw_rad(double time_s) const;
  [[nodiscard]] Pose wrist(double time_s) const;
  [[nodiscard]] Pose along_path(double time_s) const;

  CameraPath path_;
  MotionConfig config_;
  double duration_s_;
  std::vector<Wobble> shifts_m_;   ///< sway and tremor along x, y, z
  std::vector<Wobble> turns_rad_;  ///< about x, y, z
  std::vector<Turn> looks_aside_;
  std::vector<Stop> stops_;
};

}  // namespace scanknit
