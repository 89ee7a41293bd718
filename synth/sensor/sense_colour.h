// From the exact colours to those that a colour camera reports.
#pragma once

#include <cstdint>
#include <vector>

#include "core/image.h"
#include "synth/sensor/rendered_sensor.h"

namespace scanknit {

/// The mean light of pictures of one size, taken at several moments of one exposure: motion blur. At least one. Light
/// is the square of the sRGB value, near enough to the standard's curve.
[[nodiscard]] ColourImage blurred(const std::vector<ColourImage>& moments);

/// Exposure, gain and white balance that follow the picture's brightness, then noise, which grows with the gain. A pure
/// function, the same for any number of threads.
[[nodiscard]] ColourImage sense_colour(const ColourImage& exact, const ColourModel& model, std::uint64_t seed,
                                       std::uint64_t frame);

}  // namespace scanknit
