#include "acquire/pcl/cloud_picture.h"

#include <cmath>
#include <utility>

#include "acquire/line_sums.h"

namespace scanknit {
namespace {

constexpr double kMaxPixelResidual = 1.0;  // a cloud whose points miss their pixels by more is no pinhole picture
constexpr double kFewestPoints = 16;

// {focal, centre} of pixel = focal * slope + centre; nothing when the points do not determine them, or do not follow
// them.
std::optional<std::pair<double, double>> focal_and_centre(const LineSums& pixel_of_slope) {
  if (pixel_of_slope.n < kFewestPoints) return std::nullopt;
  if (!(pixel_of_slope.variance() > 1e-8)) return std::nullopt;  // a view of less than 0.0001 rad
  const double focal = pixel_of_slope.slope();
  const bool is_pinhole = std::isfinite(focal) && focal != 0 && pixel_of_slope.residual() <= kMaxPixelResidual;
  if (!is_pinhole) return std::nullopt;
  return std::pair(focal, (pixel_of_slope.y - focal * pixel_of_slope.x) / pixel_of_slope.n);
}

}  // namespace

CloudPicture picture_of_cloud(int width, int height, const std::vector<Eigen::Vector3f>& points_m) {
  CloudPicture picture{DepthImage(width, height), {}};
  LineSums across;
  LineSums down;
  std::size_t i = 0;
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u, ++i) {
      const Eigen::Vector3f& p = points_m[i];
      if (!p.allFinite() || !(p.z() > 0)) continue;
      picture.depth_m.at(u, v) = p.z();
      across.add(double{p.x()} / p.z(), u);
      down.add(double{p.y()} / p.z(), v);
    }
  }
  const auto horizontal = focal_and_centre(across);
  const auto vertical = focal_and_centre(down);
  picture.has_enough_points = across.n >= kFewestPoints;
  if (horizontal && vertical) {
    picture.camera =
        CameraIntrinsics{width, height, horizontal->first, vertical->first, horizontal->second, vertical->second};
  }
  return picture;
}

}  // namespace scanknit
