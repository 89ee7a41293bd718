// The original 15 cases, for teaching: what happens when neighbours do not agree.
#pragma once

#include <bit>

#include "extract/cell/cell.h"

namespace scanknit {

/// Lorensen & Cline 1987: fifteen configurations, spread over the 256 cases by rotation and by complement. A
/// configuration separates its Highs; its complement, the same triangles turned over, therefore joins them. A cell with
/// at most four Highs and its neighbour with more see the face that they share differently: a hole. Durst 1988.
[[nodiscard]] constexpr FaceMask lorensen_joined_faces(CornerMask highs) {
  return std::popcount(highs) <= 4 ? FaceMask{0} : kAmbiguousFaces[highs];
}

}  // namespace scanknit
