#include "fusion/align/local_features.h"

#include <pcl/features/fpfh.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace scanknit {

std::vector<SurfaceFeature> surface_features(const OrientedPoints& points, double radius_m) {
  const pcl::PointCloud<pcl::PointXYZ>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZ>);
  const pcl::PointCloud<pcl::Normal>::Ptr normals(new pcl::PointCloud<pcl::Normal>);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f& p = points.points_m[i];
    const Eigen::Vector3f& n = points.normals[i];
    cloud->push_back({p.x(), p.y(), p.z()});
    normals->push_back({n.x(), n.y(), n.z()});
  }
  std::vector<SurfaceFeature> features(points.size(), SurfaceFeature{});
  if (points.size() < 2) return features;
  pcl::FPFHEstimation<pcl::PointXYZ, pcl::Normal, pcl::FPFHSignature33> estimation;
  estimation.setInputCloud(cloud);
  estimation.setInputNormals(normals);
  estimation.setSearchMethod(pcl::search::KdTree<pcl::PointXYZ>::Ptr(new pcl::search::KdTree<pcl::PointXYZ>));
  estimation.setRadiusSearch(radius_m);
  pcl::PointCloud<pcl::FPFHSignature33> histograms;
  estimation.compute(histograms);
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t k = 0; k < features[i].size(); ++k) {
      const float value = histograms[i].histogram[k];
      features[i][k] = std::isfinite(value) ? value : 0;
    }
  }
  return features;
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
