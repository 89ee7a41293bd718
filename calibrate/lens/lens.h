// The lens as nine numbers, and how a picture depends on them.
#pragma once

#include <Eigen/Core>

#include "acquire/acquire_config.h"

namespace scanknit {

/// fx fy cx cy in pixels, then k1 k2 p1 p2 k3 as in Distortion.
using LensVector = Eigen::Matrix<double, 9, 1>;
using LensMatrix = Eigen::Matrix<double, 9, 9>;

[[nodiscard]] LensVector lens_of(const CameraModel& model);
[[nodiscard]] CameraModel model_of(const LensVector& lens, int width, int height);

/// A point's pixel and its derivatives.
struct Projection {
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, 9> by_lens;
  Eigen::Matrix<double, 2, 6> by_pose;  ///< of T in exp(delta) T: shift, then turn, both in the camera's frame
};

/// p_camera.z() > 0. D. C. Brown 1966; J. G. Fryer and D. C. Brown 1986: x' = x L + 2 p1 x y + p2 (r2 + 2 x2),
/// y' = y L + p1 (r2 + 2 y2) + 2 p2 x y, L = 1 + k1 r2 + k2 r4 + k3 r6, at depth 1.
[[nodiscard]] Projection project(const LensVector& lens, const Eigen::Vector3d& p_camera);

/// The ideal position at depth 1 that the lens shows at `pixel`, by fixed-point steps; for distortions of usual lenses.
[[nodiscard]] Eigen::Vector2d straighten(const LensVector& lens, const Eigen::Vector2d& pixel);

}  // namespace scanknit
