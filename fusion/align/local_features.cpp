#include "fusion/align/local_features.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstdint>

#include "fusion/align/align_pcl.h"

namespace scanknit {

Result<std::vector<SurfaceFeature>> surface_features(const OrientedPoints& points, double radius_m) {
  if (points.size() < 2) return std::vector<SurfaceFeature>(points.size(), SurfaceFeature{});
  const auto pcl = load_align_pcl();
  if (!pcl) return pcl.error();
  return (*pcl)->describe_points(points, radius_m);
}

std::vector<std::vector<std::uint32_t>> nearest_features(const std::vector<SurfaceFeature>& from,
                                                         const std::vector<SurfaceFeature>& to, std::size_t count) {
  std::vector<std::vector<std::uint32_t>> nearest(from.size());
  tbb::parallel_for(std::size_t{0}, from.size(), [&](std::size_t i) {
    std::vector<std::pair<float, std::uint32_t>> distances(to.size());
    for (std::size_t k = 0; k < to.size(); ++k) {
      float squared = 0;
      for (std::size_t bin = 0; bin < from[i].size(); ++bin) {
        const float difference = from[i][bin] - to[k][bin];
        squared += difference * difference;
      }
      distances[k] = {squared, static_cast<std::uint32_t>(k)};
    }
    const auto kept = static_cast<std::ptrdiff_t>(std::min(count, distances.size()));
    std::partial_sort(distances.begin(), distances.begin() + kept, distances.end());
    for (std::ptrdiff_t k = 0; k < kept; ++k) nearest[i].push_back(distances[static_cast<std::size_t>(k)].second);
  });
  return nearest;
}

}  // namespace scanknit
