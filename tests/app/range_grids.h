// Range grids of a surface that is known, as files, for the tests of `align`.
#pragma once

#include <Eigen/Geometry>
#include <filesystem>

#include "core/pose.h"

namespace scanknit {

/// A hilly country of 12 cm x 12 cm of which no two places are alike, seen from above through parallel lines, from
/// `first_x_m` on along x. Written as a Stanford range grid in a frame of its own: p_grid = T_grid_world * p_world,
/// where the turn is about z only, since the grid's lines of sight run along it.
void write_hills(const std::filesystem::path& path, double first_x_m, const Pose& T_grid_world);

/// The height of the country.
[[nodiscard]] double hills_m(double x_m, double y_m);

}  // namespace scanknit
