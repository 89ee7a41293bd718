// Deviations as colours.
#pragma once

#include <span>
#include <vector>

#include "core/image.h"

namespace scanknit {

/// Blue: below, towards -end_m; grey: none; red: above. Beyond the ends, the colour of the end.
[[nodiscard]] Rgb8 deviation_colour(double distance_m, double end_m);
[[nodiscard]] std::vector<Rgb8> deviation_colours(std::span<const double> distances_m, double end_m);

}  // namespace scanknit
