#include "measure/compare/deviation_regions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace scanknit {
namespace {

constexpr auto kRegions = static_cast<std::size_t>(kRegionsPerAxis * kRegionsPerAxis * kRegionsPerAxis);

/// Which part of an axis a coordinate is in; 0 on an axis without extent.
int part_of(double value, double low, double high) {
  if (!(high > low)) return 0;
  return std::clamp(static_cast<int>(std::floor((value - low) / (high - low) * kRegionsPerAxis)), 0,
                    kRegionsPerAxis - 1);
}

Eigen::AlignedBox3d part_of(const Eigen::AlignedBox3d& box_m, std::size_t region) {
  constexpr auto kParts = static_cast<std::size_t>(kRegionsPerAxis);
  const Eigen::Vector3d part = box_m.sizes() / kRegionsPerAxis;
  const Eigen::Vector3d place(static_cast<double>(region % kParts), static_cast<double>(region / kParts % kParts),
                              static_cast<double>(region / (kParts * kParts)));
  const Eigen::Vector3d low = box_m.min() + place.cwiseProduct(part);
  return {low, low + part};
}

}  // namespace

std::vector<DeviationRegion> deviation_regions(std::span<const Eigen::Vector3d> points_m,
                                               std::span<const double> distances_m, const Eigen::AlignedBox3d& box_m,
                                               std::optional<double> tolerance_m) {
  std::array<std::vector<double>, kRegions> distances;
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    int region = 0;
    for (const int axis : {2, 1, 0}) {
      region = region * kRegionsPerAxis + part_of(points_m[i][axis], box_m.min()[axis], box_m.max()[axis]);
    }
    distances[static_cast<std::size_t>(region)].push_back(distances_m[i]);
  }
  std::vector<DeviationRegion> regions;
  for (std::size_t i = 0; i < kRegions; ++i) {
    if (distances[i].empty()) continue;
    DeviationRegion region;
    region.box_m = part_of(box_m, i);
    region.area_share = static_cast<double>(distances[i].size()) / static_cast<double>(points_m.size());
    if (tolerance_m) region.beyond = share_beyond(distances[i], *tolerance_m);
    region.area = deviation_stats(std::move(distances[i]));
    regions.push_back(std::move(region));
  }
  return regions;
}

}  // namespace scanknit
