// RangeSurface: the surface of a range scan, made of neighbours in its grid.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/image.h"
#include "core/mesh.h"
#include "core/range_scan.h"

namespace scanknit {

/// It is cut at depth steps: neighbours farther apart than a few sample spacings belong to two surfaces, and the space
/// between is unknown. All pictures are as large as the scan's grid.
struct RangeSurface {
  std::vector<Triangle> triangles;  ///< of cells x + width y, counter-clockwise seen from the scanner
  Image<Eigen::Vector3f> normals;   ///< unit, towards the scanner; zero where no triangle meets the point
  Image<std::uint8_t> inset;        ///< steps to the surface's rim, at most kDeepest; 0: no triangle meets the point
  double spacing_m = 0;             ///< median distance of neighbours
  double noise_m = 0;               ///< estimated standard deviation across the surface; includes curvature

  static constexpr std::uint8_t kDeepest = 4;
};

[[nodiscard]] RangeSurface find_surface(const RangeScan& scan);

}  // namespace scanknit
