#include "measure/compare/deviation_colours.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>

namespace scanknit {
namespace {

constexpr Rgb8 kDeviationRamp[] = {{38, 70, 160}, {60, 170, 180}, {215, 215, 210}, {245, 190, 60}, {214, 48, 39}};

}  // namespace

Rgb8 deviation_colour(double distance_m, double end_m) {
  constexpr std::size_t kSteps = std::size(kDeviationRamp) - 1;
  const double place = std::clamp((distance_m / end_m + 1) / 2, 0.0, 1.0) * static_cast<double>(kSteps);
  const auto step = std::min(static_cast<std::size_t>(place), kSteps - 1);
  const double share = place - static_cast<double>(step);
  const auto mix = [share](std::uint8_t a, std::uint8_t b) {
    return static_cast<std::uint8_t>(std::lround(a + share * (b - a)));
  };
  const Rgb8 &from = kDeviationRamp[step], &to = kDeviationRamp[step + 1];
  return {mix(from.r, to.r), mix(from.g, to.g), mix(from.b, to.b)};
}

std::vector<Rgb8> deviation_colours(std::span<const double> distances_m, double end_m) {
  std::vector<Rgb8> colours;
  colours.reserve(distances_m.size());
  for (const double d : distances_m) colours.push_back(deviation_colour(d, end_m));
  return colours;
}

}  // namespace scanknit
