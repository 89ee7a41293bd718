#include <algorithm>

#include "acquire/layouts/pcd_points.h"
#include "acquire/range/range_files.h"

namespace scanknit {
namespace {

RangeScan to_scan(PcdPoints&& points, const Pose& T_world_scan) {
  RangeScan scan;
  scan.points_m = Image<Eigen::Vector3f>(points.header.width, points.header.height, kNoReturn);
  for (std::size_t i = 0; i < points.points_m.size(); ++i) {
    const Eigen::Vector3f& p = points.points_m[i];
    if (p.allFinite() && !p.isZero(0)) scan.points_m.pixels()[i] = p;
  }
  if (!points.colours.empty()) {
    scan.colours = Image<Rgb8>(points.header.width, points.header.height);
    std::copy(points.colours.begin(), points.colours.end(), scan.colours.pixels().begin());
  }
  scan.sight = {.kind = SightLines::Kind::kSphere, .pole = 1};
  scan.T_world_scan = T_world_scan;
  return scan;
}

PointCloud to_cloud(const PcdPoints& points) {
  PointCloud cloud;
  for (std::size_t i = 0; i < points.points_m.size(); ++i) {
    if (!points.points_m[i].allFinite()) continue;
    cloud.points_m.push_back(points.points_m[i]);
    if (!points.colours.empty()) cloud.colours.push_back(points.colours[i]);
    if (points.normals.empty()) continue;
    const Eigen::Vector3f& n = points.normals[i];
    cloud.normals.push_back(n.allFinite() ? Eigen::Vector3f(n.stableNormalized()) : Eigen::Vector3f::Zero());
  }
  return cloud;
}

}  // namespace

Result<RangeFile> parse_pcd_range(std::string_view bytes, const Limits& limits) {
  auto points = parse_pcd_points(std::as_bytes(std::span(bytes)), limits);
  if (!points) return points.error();
  RangeFile file;
  if (points->header.height < 2 || points->header.width < 2) {
    file.clouds.push_back(to_cloud(*points));
    return file;
  }
  const auto pose = viewpoint_pose(points->header);
  if (!pose) return pose.error();
  file.scans.push_back(to_scan(*std::move(points), *pose));
  return file;
}

}  // namespace scanknit
