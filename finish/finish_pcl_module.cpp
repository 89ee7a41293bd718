// The module libscanknit_finish_pcl.so.
#include <pcl/ModelCoefficients.h>
#include <pcl/PointIndices.h>
#include <pcl/console/print.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/segmentation/sac_segmentation.h>

#include "core/version.h"
#include "finish/finish_pcl.h"

namespace scanknit {
namespace {

constexpr int kTries = 2000;

std::optional<Eigen::Vector4d> find_plane(const std::vector<Eigen::Vector3f>& points_m, const GroundSearch& search) {
  using Cloud = pcl::PointCloud<pcl::PointXYZ>;
  const Cloud::Ptr cloud(new Cloud);
  for (const Eigen::Vector3f& p : points_m) cloud->push_back({p.x(), p.y(), p.z()});
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);             // a library never prints on input
  pcl::SACSegmentation<pcl::PointXYZ> segmentation(/*random=*/false);  // a fixed seed
  segmentation.setModelType(pcl::SACMODEL_PERPENDICULAR_PLANE);
  segmentation.setMethodType(pcl::SAC_RANSAC);
  segmentation.setAxis(search.expected_up.cast<float>());
  segmentation.setEpsAngle(search.max_tilt_rad);
  segmentation.setDistanceThreshold(search.tolerance_m);
  segmentation.setMaxIterations(kTries);
  segmentation.setOptimizeCoefficients(false);
  segmentation.setInputCloud(cloud);
  pcl::PointIndices on_plane;
  pcl::ModelCoefficients plane;
  segmentation.segment(on_plane, plane);
  if (plane.values.size() != 4 || on_plane.indices.size() < 3) return std::nullopt;
  return Eigen::Vector4d(plane.values[0], plane.values[1], plane.values[2], plane.values[3]);
}

}  // namespace
}  // namespace scanknit

extern "C" __attribute__((visibility("default"))) const scanknit::ModuleEntry* scanknit_module() {
  using namespace scanknit;
  static constexpr FinishPcl kOffers{find_plane};
  static constexpr ModuleEntry kEntry{kVersion, &kOffers};
  return &kEntry;
}
