// RangeSurface: the surface that a range scan shows, as far as neighbours in its grid lie on it.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/image.h"
#include "core/mesh.h"
#include "core/range_scan.h"

namespace scanknit {

/// Steps in depth are cut: neighbours farther from each other than a few sample spacings lie on two surfaces, and
/// nobody knows what is between. All pictures are as large as the scan's grid.
struct RangeSurface {
  std::vector<Triangle> triangles;  ///< of cells x + width y, counter-clockwise seen from the scanner
  Image<Eigen::Vector3f> normals;   ///< unit, towards the scanner; zero where no triangle meets the point
  Image<std::uint8_t> inset;        ///< steps to the surface's rim, at most kDeepest; 0: no triangle meets the point
  double spacing_m = 0;             ///< between neighbours, median
  double noise_m = 0;               ///< standard deviation across the surface, estimated; curvature is part of it

  static constexpr std::uint8_t kDeepest = 4;
};

[[nodiscard]] RangeSurface find_surface(const RangeScan& scan);

}  // namespace scanknit
