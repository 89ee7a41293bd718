#include "finish/ground_plane.h"

#include <pcl/ModelCoefficients.h>
#include <pcl/PointIndices.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/segmentation/sac_segmentation.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

namespace scanknit {
namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

constexpr std::size_t kMostPoints = 60'000;  // that candidates are tried on
constexpr int kTries = 2000;
constexpr double kAgreement = 0.8;  // cosine between a triangle and the plane that it lies on, 37 degrees

struct Facet {
  Eigen::Vector3d middle, normal;  ///< unit
  double area_m2;
};

std::vector<Facet> facets_of(const Mesh& mesh) {
  std::vector<Facet> facets;
  facets.reserve(mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) {
    const auto at = [&](std::size_t i) { return mesh.positions_m[t[i]].cast<double>().eval(); };
    const Eigen::Vector3d across = (at(1) - at(0)).cross(at(2) - at(0));
    const double twice = across.norm();
    if (!(twice > 0)) continue;
    facets.push_back({(at(0) + at(1) + at(2)) / 3, across / twice, twice / 2});
  }
  return facets;
}

/// Facets that face up as the ground may, thinned out evenly; a triangle of an extracted mesh is about a voxel large.
Cloud::Ptr candidates(const std::vector<Facet>& facets, const GroundSearch& search) {
  std::vector<Eigen::Vector3d> points;
  for (const Facet& facet : facets) {
    if (facet.normal.dot(search.expected_up) > std::cos(search.max_tilt_rad)) points.push_back(facet.middle);
  }
  const std::size_t every = points.size() / kMostPoints + 1;
  const Cloud::Ptr cloud(new Cloud);
  for (std::size_t i = 0; i < points.size(); i += every) {
    const Eigen::Vector3f p = points[i].cast<float>();
    cloud->push_back({p.x(), p.y(), p.z()});
  }
  return cloud;
}

/// Of the facets that lie on the plane: its least-squares plane, and how much they are.
struct Fit {
  double area_m2 = 0;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  double rms_m = 0;
};

Fit fit_to(const std::vector<Facet>& facets, const Eigen::Vector3d& up, const Eigen::Vector3d& point,
           double tolerance_m) {
  Fit fit;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  const auto is_on = [&](const Facet& facet) {
    return std::abs(up.dot(facet.middle - point)) <= tolerance_m && facet.normal.dot(up) >= kAgreement;
  };
  for (const Facet& facet : facets) {
    if (!is_on(facet)) continue;
    fit.area_m2 += facet.area_m2;
    sum += facet.area_m2 * facet.middle;
  }
  if (!(fit.area_m2 > 0)) return fit;
  fit.middle = sum / fit.area_m2;
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Facet& facet : facets) {
    if (!is_on(facet)) continue;
    const Eigen::Vector3d away = facet.middle - fit.middle;
    spread += facet.area_m2 / fit.area_m2 * away * away.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
  fit.normal = axes.eigenvectors().col(0);
  if (fit.normal.dot(up) < 0) fit.normal = -fit.normal;
  fit.rms_m = std::sqrt(std::max(0.0, axes.eigenvalues()[0]));
  return fit;
}

}  // namespace

std::optional<GroundPlane> find_ground(const Mesh& mesh, const GroundSearch& search) {
  const std::vector<Facet> facets = facets_of(mesh);
  const Cloud::Ptr cloud = candidates(facets, search);
  if (cloud->size() < 3) return std::nullopt;
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

  Eigen::Vector3d up(plane.values[0], plane.values[1], plane.values[2]);
  const double length = up.norm();
  if (!(length > 0)) return std::nullopt;
  Eigen::Vector3d point = -plane.values[3] / (length * length) * up;
  up /= up.dot(search.expected_up) < 0 ? -length : length;
  Fit fit = fit_to(facets, up, point, search.tolerance_m);
  for (int again = 0; again < 3 && fit.area_m2 > 0; ++again) {
    up = fit.normal;
    point = fit.middle;
    fit = fit_to(facets, up, point, search.tolerance_m);
  }
  double whole_m2 = 0;
  for (const Facet& facet : facets) whole_m2 += facet.area_m2;
  const double tilt = std::acos(std::clamp(up.dot(search.expected_up), -1.0, 1.0));
  if (!(fit.area_m2 >= search.min_share * whole_m2) || tilt > search.max_tilt_rad) return std::nullopt;
  return GroundPlane{up, point, fit.area_m2, fit.area_m2 / whole_m2, fit.rms_m, tilt};
}

}  // namespace scanknit
