#include "export/picture/uncertainty_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <string>
#include <vector>

#include "core/check.h"
#include "core/median.h"
#include "export/picture/colour_ramp.h"
#include "export/picture/colour_scale.h"
#include "export/picture/preview.h"
#include "export/picture/surface_fit.h"

namespace scanknit {
namespace {

constexpr double kMillimetresOfMetre = 1000;

std::vector<float> known_of(std::span<const float> uncertainty_m) {
  std::vector<float> known_m;
  std::copy_if(uncertainty_m.begin(), uncertainty_m.end(), std::back_inserter(known_m),
               [](float sigma_m) { return !std::isnan(sigma_m); });
  return known_m;
}

}  // namespace

double uncertainty_map_end_m(std::span<const float> uncertainty_m) {
  std::vector<float> known_m = known_of(uncertainty_m);
  return rounded_scale_end_m(static_cast<double>(percentile(known_m, 0.95)));
}

ColourImage draw_uncertainty_map(const Mesh& mesh, std::span<const float> uncertainty_m, UpAxis world_up,
                                 const std::optional<Pose>& T_world_scanner) {
  SCANKNIT_CHECK(uncertainty_m.size() == mesh.positions_m.size());
  const double end_m = uncertainty_map_end_m(uncertainty_m);
  std::vector<Rgb8> painted(mesh.positions_m.size());
  for (std::size_t i = 0; i < painted.size(); ++i) {
    const auto sigma_m = static_cast<double>(uncertainty_m[i]);
    painted[i] = std::isnan(sigma_m) ? kUnseenColour : colour_on(kErrorRamp, sigma_m / end_m);
  }
  constexpr int kSteps = 512;
  std::vector<Rgb8> colours;
  for (int i = 0; i < kSteps; ++i) colours.push_back(colour_on(kErrorRamp, static_cast<double>(i) / (kSteps - 1)));
  std::vector<ScaleLabel> labels;
  for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    labels.push_back({share, fmt::format("{:.4g} mm", share * end_m * kMillimetresOfMetre)});
  }
  std::vector<float> known_m = known_of(uncertainty_m);
  const auto unknown = static_cast<double>(uncertainty_m.size() - known_m.size());
  std::string title = fmt::format("uncertainty, one standard deviation: median {:.3g} mm",
                                  static_cast<double>(percentile(known_m, 0.5)) * kMillimetresOfMetre);
  if (unknown > 0) {
    title += fmt::format("; unknown {:.3g} % (grey)", 100 * unknown / static_cast<double>(uncertainty_m.size()));
  }
  return with_colour_scale(render_two_views(mesh, world_up, T_world_scanner, painted), colours, labels, title);
}

}  // namespace scanknit
