#include "acquire/filter/outlier_filter.h"

#include <pcl/filters/statistical_outlier_removal.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <cstddef>
#include <utility>
#include <vector>

#include "core/check.h"

namespace scanknit {

DepthImage remove_statistical_outliers(const DepthImage& depth_m, const CameraIntrinsics& intrinsics, int neighbours,
                                       double std_multiplier) {
  SCANKNIT_CHECK(intrinsics.is_valid() && intrinsics.width == depth_m.width() && intrinsics.height == depth_m.height());
  auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  std::vector<std::pair<int, int>> pixels;
  for (int y = 0; y < depth_m.height(); ++y) {
    for (int x = 0; x < depth_m.width(); ++x) {
      if (!(depth_m.at(x, y) > 0)) continue;
      const Eigen::Vector3f p_camera = intrinsics.unproject(x, y, depth_m.at(x, y)).cast<float>();
      cloud->push_back({p_camera.x(), p_camera.y(), p_camera.z()});
      pixels.emplace_back(x, y);
    }
  }
  if (neighbours <= 0 || pixels.size() <= static_cast<std::size_t>(neighbours)) return depth_m;

  pcl::StatisticalOutlierRemoval<pcl::PointXYZ> filter;
  filter.setInputCloud(cloud);
  filter.setMeanK(neighbours);
  filter.setStddevMulThresh(std_multiplier);
  std::vector<int> kept;
  filter.filter(kept);
  DepthImage cleaned(depth_m.width(), depth_m.height());
  for (const int index : kept) {
    const auto [x, y] = pixels[static_cast<std::size_t>(index)];
    cleaned.at(x, y) = depth_m.at(x, y);
  }
  return cleaned;
}

}  // namespace scanknit
