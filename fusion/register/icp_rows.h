// Compares one row of a frame with a model view: the inner loop of registration.
#pragma once

#include <array>

#include "core/frame_timing.h"
#include "core/noise_model.h"
#include "core/pose.h"
#include "fusion/register/surface_pyramid.h"

namespace scanknit {

/// Which points make a pair, and with which weight.
struct PairGate {
  float distance_m = 0;            ///< pairs farther apart than this ...
  float distance_per_m = 0;        ///< ... plus this share of their depth are not used
  float min_cosine = 0;            ///< between the normals
  float tukey_sigmas = 0;          ///< a residual beyond this many sigma has weight 0 (Beaton & Tukey 1974)
  float contradiction_m = 0;       ///< depths that differ by more than this ...
  float contradiction_sigmas = 0;  ///< ... plus so many sigma cannot be of the same surface
  float inlier_sigmas = 0;         ///< a residual within is an inlier
  float intensity_sigma = 0;       ///< standard deviation of intensity; 0: colour is not used
  float intensity_offset = 0;      ///< brightness of the frame minus that of the model
  float colour_weight = 1;         ///< a difference of intensity counts so much in the normal equations
};

/// Sums over pairs. Rows of J: the derivative of a residual in units of its sigma, by the motion of the frame's points
/// in the view: translation (m), then rotation about `centre` times `scale_m`.
struct PairSums {
  std::array<double, 21> JtJ{};  ///< upper triangle, row by row
  std::array<double, 6> Jtr{};
  double information = 0;     ///< of distances: sum of weight / sigma^2
  double weights = 0;         ///< of distances
  double squares = 0;         ///< weighted, of distances in sigma
  double contradictions = 0;  ///< pairs whose depths differ by more than noise and edges explain
  double coloured = 0;        ///< pairs whose intensity is compared
  double colour_weights = 0;
  double colour_offset = 0;     ///< weighted sum of (frame - model), before intensity_offset
  std::array<double, 6> JtD{};  ///< D: the derivative of intensities by Registration::colour_later
  double DtD = 0, Dtr = 0;
  double points = 0;   ///< of the frame
  double seen = 0;     ///< points that project to a surface in the view
  double inliers = 0;  ///< of those

  PairSums& operator+=(const PairSums& other);
};

/// A frame's level in a view's level of any size.
struct Registration {
  const SurfaceLevel* frame;
  const SurfaceLevel* model;
  Pose T_model_frame;          ///< of the middle row
  SteadyMotion rows;           ///< of the frame's camera, from the first row to the last
  SteadyMotion colour_motion;  ///< of the frame's camera, along which colours are moved
  double colour_later = 0;     ///< by this share of it
  NoiseModel noise;
  PairGate gate;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< in the view
  double scale_m = 1;
};

/// Residuals of row y. Point to plane: n . (T p - q) for the pixel q that T p projects to (Chen & Medioni 1991; Blais &
/// Levine 1995), and the difference of intensity there (as ElasticFusion: Whelan et al. 2015). Eight pixels at a time
/// on the widest instructions of the processor; each operation is rounded as IEEE 754 says, none fused, and sums run in
/// eight lanes on every machine, so all give the same bits.
[[nodiscard]] PairSums sum_row(const Registration& registration, int y);

}  // namespace scanknit
