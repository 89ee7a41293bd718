// What the surface round a point looks like, as numbers that do not change when the scan is moved.
#pragma once

#include <array>
#include <vector>

#include "core/result.h"
#include "fusion/align/scan_model.h"

namespace scanknit {

using SurfaceFeature = std::array<float, 33>;

/// Fast point feature histograms (Rusu, Blodow, Beetz 2009) by PCL, one a point, over neighbours within `radius_m`.
/// A point without neighbours has zeros. One thread, the same bits every time. Error (kInternal): the module for PCL is
/// missing (fusion/align/align_pcl.h).
[[nodiscard]] Result<std::vector<SurfaceFeature>> surface_features(const OrientedPoints& points, double radius_m);

/// For each feature of `from` the numbers of the `count` nearest of `to`, nearest first.
[[nodiscard]] std::vector<std::vector<std::uint32_t>> nearest_features(const std::vector<SurfaceFeature>& from,
                                                                       const std::vector<SurfaceFeature>& to,
                                                                       std::size_t count);

}  // namespace scanknit
