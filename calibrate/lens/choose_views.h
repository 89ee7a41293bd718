// Chooses the views that tell the most of the lens.
#pragma once

#include <cstddef>
#include <vector>

#include "calibrate/lens/lens.h"

namespace scanknit {

/// At most `most` of the views, by their place in the list: one after the other the view that raises the determinant of
/// the sum of information() most (greedy D-optimal design; Fedorov 1972), so that views alike are not taken twice while
/// others lack. In ascending order.
[[nodiscard]] std::vector<std::size_t> choose_views(const std::vector<LensMatrix>& informations, std::size_t most);

}  // namespace scanknit
