// Rotations spread evenly, to begin searches with.
#pragma once

#include <Eigen/Geometry>
#include <vector>

namespace scanknit {

/// The 60 rotations of an icosahedron, that by nothing first: none is more than 45 degrees from one of them. Of each
/// pair of opposite vertices of the 600-cell one (Coxeter 1973, "Regular Polytopes", section 8.7).
[[nodiscard]] std::vector<Eigen::Quaterniond> icosahedral_rotations();

}  // namespace scanknit
