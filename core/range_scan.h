// RangeScan: an organised grid of points that a range scanner measured from one place, without a pinhole.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <string>

#include "core/image.h"
#include "core/pixels/sight_lines.h"
#include "core/pose.h"

namespace scanknit {

/// Neighbours in the grid are neighbours on the surface, or are on both sides of a depth step.
struct RangeScan {
  std::string name;                       ///< of the file, for messages
  Image<Eigen::Vector3f> points_m;        ///< the scan's own frame; x is NaN where there was no return
  Image<Rgb8> colours;                    ///< sRGB; empty, or as large as `points_m`
  SightLines sight;                       ///< in the scan's own frame
  std::optional<Pose> T_world_scan = {};  ///< from the file; rigid and finite
};

[[nodiscard]] inline bool has_return(const Eigen::Vector3f& p) {
  return !std::isnan(p.x());
}

inline const Eigen::Vector3f kNoReturn(NAN, NAN, NAN);

}  // namespace scanknit
