#include "acquire/filter/outlier_filter.h"

#include <cstddef>
#include <utility>
#include <vector>

#include "acquire/pcl/acquire_pcl.h"
#include "core/check.h"

namespace scanknit {

Result<DepthImage> remove_statistical_outliers(const DepthImage& depth_m, const CameraIntrinsics& intrinsics,
                                               int neighbours, double std_multiplier) {
  SCANKNIT_CHECK(intrinsics.is_valid() && intrinsics.width == depth_m.width() && intrinsics.height == depth_m.height());
  std::vector<Eigen::Vector3f> points_m;
  std::vector<std::pair<int, int>> pixels;
  for (int y = 0; y < depth_m.height(); ++y) {
    for (int x = 0; x < depth_m.width(); ++x) {
      if (!(depth_m.at(x, y) > 0)) continue;
      points_m.push_back(intrinsics.unproject(x, y, depth_m.at(x, y)).cast<float>());
      pixels.emplace_back(x, y);
    }
  }
  if (neighbours <= 0 || pixels.size() <= static_cast<std::size_t>(neighbours)) return depth_m;

  const auto pcl = load_acquire_pcl();
  if (!pcl) return pcl.error();
  DepthImage cleaned(depth_m.width(), depth_m.height());
  for (const int index : (*pcl)->find_inliers(points_m, neighbours, std_multiplier)) {
    const auto [x, y] = pixels[static_cast<std::size_t>(index)];
    cleaned.at(x, y) = depth_m.at(x, y);
  }
  return cleaned;
}

}  // namespace scanknit
