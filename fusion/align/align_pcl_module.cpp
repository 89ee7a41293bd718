// The module libscanknit_align_pcl.so.
#include <pcl/features/fpfh.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>

#include <cmath>

#include "core/version.h"
#include "fusion/align/align_pcl.h"

namespace scanknit {
namespace {

std::vector<SurfaceFeature> describe_points(const OrientedPoints& points, double radius_m) {
  const pcl::PointCloud<pcl::PointXYZ>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZ>);
  const pcl::PointCloud<pcl::Normal>::Ptr normals(new pcl::PointCloud<pcl::Normal>);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f& p = points.points_m[i];
    const Eigen::Vector3f& n = points.normals[i];
    cloud->push_back({p.x(), p.y(), p.z()});
    normals->push_back({n.x(), n.y(), n.z()});
  }
  std::vector<SurfaceFeature> features(points.size(), SurfaceFeature{});
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

}  // namespace
}  // namespace scanknit

extern "C" __attribute__((visibility("default"))) const scanknit::ModuleEntry* scanknit_module() {
  using namespace scanknit;
  static constexpr AlignPcl kOffers{describe_points};
  static constexpr ModuleEntry kEntry{kVersion, &kOffers};
  return &kEntry;
}
