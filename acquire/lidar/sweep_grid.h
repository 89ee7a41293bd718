// A LiDAR sweep as a grid: a row for each laser, columns by azimuth.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "acquire/lidar/sweep_source.h"
#include "core/range_scan.h"

namespace scanknit {

/// Which row each point is in, 0 the highest elevation.
struct SweepRows {
  enum class Kind {
    kRings,       ///< the recording names the laser of each point
    kOrder,       ///< turn after turn, a laser each, as KITTI's files are written
    kElevations,  ///< lasers are told apart by their elevation
    kUniform,     ///< lasers are not known: rows of kUniformStep_deg
  };
  static constexpr double kUniformStep_deg = 0.4;  ///< about the spacing of the lasers of an HDL-64E

  Kind kind = Kind::kUniform;
  std::vector<std::uint16_t> row_of_point;
  int rows = 0;
};

[[nodiscard]] SweepRows find_rows(const Sweep& sweep);

/// What of a sweep counts.
struct SweepRange {
  double min_m = 0, max_m = 0;  ///< distances from the sensor; 0: no limit
};

/// The nearest return of each cell counts. The first column is repeated behind the last, so that the surface closes
/// round the sensor. Empty where no point is in range.
[[nodiscard]] RangeScan grid_of(const Sweep& sweep, const SweepRange& range);

}  // namespace scanknit
