// Along which lines a scanner looked, read off its grid.
#pragma once

#include "core/image.h"
#include "core/sight_lines.h"

namespace scanknit {

/// For a scanner that looks along -z. Where the points of a row (a column) lie on a line in y and z (x and z), that
/// line is the row's line of sight; the lines of all rows give the slit. Parallel along an axis where they do not.
[[nodiscard]] SightLines estimate_sight(const Image<Eigen::Vector3f>& points_m);

}  // namespace scanknit
