// The module libscanknit_finish_pcl.so.
#include <pcl/console/print.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/sample_consensus/ransac.h>
#include <pcl/sample_consensus/sac_model_perpendicular_plane.h>

#include "core/version.h"
#include "finish/finish_pcl.h"

namespace scanknit {
namespace {

constexpr int kTries = 2000;

std::optional<Eigen::Vector4d> find_plane(const std::vector<Eigen::Vector3f>& points_m, const GroundSearch& search) {
  using Cloud = pcl::PointCloud<pcl::PointXYZ>;
  using Model = pcl::SampleConsensusModelPerpendicularPlane<pcl::PointXYZ>;
  const Cloud::Ptr cloud(new Cloud);
  for (const Eigen::Vector3f& p : points_m) cloud->push_back({p.x(), p.y(), p.z()});
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);     // a library never prints on input
  const Model::Ptr model(new Model(cloud, /*random=*/false));  // a fixed seed
  model->setAxis(search.expected_up.cast<float>());
  model->setEpsAngle(search.max_tilt_rad);
  pcl::RandomSampleConsensus<pcl::PointXYZ> ransac(model, search.tolerance_m);
  ransac.setMaxIterations(kTries);
  if (!ransac.computeModel()) return std::nullopt;
  pcl::Indices on_plane;
  ransac.getInliers(on_plane);
  if (on_plane.size() < 3) return std::nullopt;
  Eigen::VectorXf plane;
  ransac.getModelCoefficients(plane);
  return plane.cast<double>();
}

}  // namespace
}  // namespace scanknit

extern "C" __attribute__((visibility("default"))) const scanknit::ModuleEntry* scanknit_module() {
  using namespace scanknit;
  static constexpr FinishPcl kOffers{find_plane};
  static constexpr ModuleEntry kEntry{kVersion, &kOffers};
  return &kEntry;
}
