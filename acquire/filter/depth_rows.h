// The inner loops of the depth filters, sixteen pixels at a time. They choose the widest instructions of the processor
// at run time; each operation is rounded as IEEE 754 says, none are fused, so all give the same bits.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/camera.h"
#include "core/pixels/pixel_rows.h"

namespace scanknit {

/// The parameters of the loop for normals, as floats.
struct NormalContext {
  NormalContext(const CameraIntrinsics& k, const NoiseModel& depth_noise);

  float fx, fy, cx, cy;
  float pitch_per_m;  ///< width of a pixel's view at 1 m
  FloatNoise noise;
};

/// 1 / z; 0 where there is no return.
void invert_row(std::span<const float> z_m, float* inverse);

/// Fills in row y: see estimate_normals. `inverse` points to its first pixel in an InverseDepth, whose rows are `pitch`
/// apart. Zero where no plane was found.
void find_row_normals(const NormalContext& context, const float* inverse, std::ptrdiff_t pitch, int y,
                      std::span<Eigen::Vector3f> normals);

/// How far each pixel of a group is off the middle of its two neighbours, `step` before and after it, in standard
/// deviations of the noise; as bits: `deviates` beyond `sigmas`, `is_unsure` where it has a return and one of the two
/// neighbours has none.
struct GroupDeviation {
  std::uint16_t deviates = 0;
  std::uint16_t is_unsure = 0;
};
[[nodiscard]] GroupDeviation find_deviations(const FloatNoise& noise, const float* inverse, std::ptrdiff_t step,
                                             float sigmas);

}  // namespace scanknit
