// Estimates a scanner's lines of sight from its grid.
#pragma once

#include "core/image.h"
#include "core/pixels/sight_lines.h"

namespace scanknit {

/// For a scanner that looks along -z. If the points of a row (a column) lie on a line in y and z (x and z), that line
/// is the row's line of sight, and the lines of all rows give the slit. If they do not, the lines are parallel along
/// that axis.
[[nodiscard]] SightLines estimate_sight(const Image<Eigen::Vector3f>& points_m);

}  // namespace scanknit
