// Depth filters: pure functions of a picture.
#pragma once

#include <Eigen/Core>

#include "acquire/acquire_config.h"
#include "core/camera.h"
#include "core/frame.h"
#include "core/image.h"
#include "core/noise_model.h"
#include "core/result.h"

namespace scanknit {

/// Depth outside [min_m, max_m] becomes 0. max_m = 0: no upper limit.
[[nodiscard]] DepthImage clip_range(const DepthImage& depth_m, double min_m, double max_m);

/// Depth at a discontinuity (flying pixels, the rim of an object) becomes 0: where it leaves the plane through its
/// neighbours along the row or the column by more than `sigmas` standard deviations of that distance. Grazing planes
/// stay, whatever their slope. Neighbours are the nearest valid pixels within 2, so that lattices of 1-pixel holes do
/// not matter. sigmas <= 0: unchanged.
[[nodiscard]] DepthImage mask_discontinuities(const DepthImage& depth_m, const NoiseModel& noise, double sigmas);

/// Edge-preserving smoothing with noise-scaled range sigma (Tomasi & Manduchi 1998).
[[nodiscard]] DepthImage smooth_bilateral(const DepthImage& depth_m, const NoiseModel& noise);

/// Unit surface normals towards the camera, zero where there are too few neighbours: the least-squares plane over a
/// star of pixels whose reach grows with noise / pixel pitch. Survives lattices of 1-pixel holes; does not reach across
/// depth discontinuities. `intrinsics` are those of `depth_m`; fy may be negative.
[[nodiscard]] Image<Eigen::Vector3f> estimate_normals(const DepthImage& depth_m, const CameraIntrinsics& intrinsics,
                                                      const NoiseModel& noise);

/// The filters that `config` asks for, in this order: range, outliers, discontinuities, bilateral, normals.
/// Error: remove_statistical_outliers()'s.
[[nodiscard]] Result<void> filter_frame(Frame& frame, const AcquireConfig& config, const NoiseModel& noise);

}  // namespace scanknit
