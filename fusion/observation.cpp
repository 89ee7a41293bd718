#include "fusion/observation.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace scanknit {
namespace {

// In front of a slanted surface the band is longer along the ray than across it, up to this slope.
constexpr float kMinSlope = 0.25f;

// Two pixels of one surface differ by sqrt(2) sigma; a neighbour that is off by three times that shows another surface.
constexpr float kSameSurfaceSigmas = 4.25f;

}  // namespace

Observation::Observation(const Frame& frame, const FusionConfig& config)
    : intrinsics_(frame.intrinsics),
      camera_(frame.intrinsics),
      pixels_(frame.depth_m.width(), frame.depth_m.height()),
      smooth_(frame.depth_m.width(), frame.depth_m.height()) {
  Image<DepthRange> bands(pixels_.width(), pixels_.height());
  tbb::parallel_for(0, pixels_.height(), [&](int y) { prepare_row(frame, config, y, bands); });
  tbb::parallel_for(0, pixels_.height(), [&](int y) {
    for (int x = 0; x < pixels_.width(); ++x) smooth_.at(x, y) = is_smooth(x, y) ? 1 : 0;
  });
  bands_ = DepthPyramid(std::move(bands));
  if (frame.colour) prepare_colour(*frame.colour);
}

void Observation::prepare_row(const Frame& frame, const FusionConfig& config, int y, Image<DepthRange>& bands) {
  const double voxels_m = config.truncation_voxels * config.voxel_size_m;
  const double best_sigma_m = config.noise.sigma_m(config.noise.from_m);
  for (int x = 0; x < pixels_.width(); ++x) {
    const float depth_m = frame.depth_m.at(x, y);
    if (!(depth_m > 0)) continue;
    const Eigen::Vector3f p = intrinsics_.unproject(x, y, static_cast<double>(depth_m)).cast<float>();
    Eigen::Vector3f normal = frame.normals.empty() ? Eigen::Vector3f::Zero() : frame.normals.at(x, y);
    if (normal.squaredNorm() == 0) normal = -p.normalized();  // unknown: as if seen head-on
    const float offset_m = normal.dot(p);                     // negative: the camera is in front of the plane

    const double sigma_m = config.noise.sigma_m(static_cast<double>(depth_m));
    const double certainty = best_sigma_m * best_sigma_m / (sigma_m * sigma_m);
    const auto truncation_m = static_cast<float>(std::max(voxels_m, config.truncation_sigmas * sigma_m));
    const float cosine = std::clamp(-offset_m / p.norm(), 0.0f, 1.0f);
    const float slope = std::max(-offset_m / depth_m, kMinSlope);  // distance to the plane per unit of z

    SurfacePixel& pixel = pixels_.at(x, y);
    pixel.plane = PixelPlane(normal.x(), normal.y(), normal.z(), offset_m);
    pixel.weight = cosine * static_cast<float>(certainty);
    pixel.truncation_m = truncation_m;
    pixel.per_truncation = 1 / truncation_m;
    pixel.same_surface_m = kSameSurfaceSigmas * static_cast<float>(sigma_m);
    bands.at(x, y) = {depth_m - truncation_m / slope, depth_m + truncation_m};
  }
}

void Observation::prepare_colour(const ColourFrame& colour) {
  colours_ = Image<Eigen::Vector4f>(colour.image.width(), colour.image.height(), Eigen::Vector4f::Zero());
  tbb::parallel_for(0, colours_.height(), [&](int y) {
    for (int x = 0; x < colours_.width(); ++x) {
      const Rgb8 pixel = colour.image.at(x, y);
      colours_.at(x, y) = Eigen::Vector4f(pixel.r, pixel.g, pixel.b, 255) / 255.0f;
    }
  });
  colour_camera_ = PictureCamera(colour.intrinsics);
  R_colour_depth_ = colour.T_colour_depth.linear().cast<float>();
  t_colour_depth_ = colour.T_colour_depth.translation().cast<float>();
}

bool Observation::is_smooth(int x, int y) const {
  for (int i = 0; i < 4; ++i) {
    if (!has_return(x + (i & 1), y + (i >> 1))) return false;
  }
  // Each pixel's point on its own ray, against the plane of the pixel diagonally across.
  for (int i = 0; i < 4; ++i) {
    const int px = x + (i & 1);
    const int py = y + (i >> 1);
    const SurfacePixel& own = pixels_.at(px, py);
    const PixelPlane& across = pixels_.at(x + 1 - (i & 1), y + 1 - (i >> 1)).plane;
    const Eigen::Vector3f ray((static_cast<float>(px) - camera_.cx) / camera_.fx,
                              (static_cast<float>(py) - camera_.cy) / camera_.fy, 1);
    const Eigen::Vector3f p = ray * (own.plane.w() / own.plane.head<3>().dot(ray));
    if (!(std::abs(across.head<3>().dot(p) - across.w()) <= own.same_surface_m)) return false;
  }
  return true;
}

Sighting Observation::sight_rough(const Eigen::Vector4f& p, const Bilinear& quad) const {
  float share[4];
  float distance_m[4];
  int nearest = 0;
  for (int i = 0; i < 4; ++i) {
    const int x = quad.x + (i & 1);
    const int y = quad.y + (i >> 1);
    share[i] = has_return(x, y) ? quad.share(i) : 0;
    distance_m[i] = share[i] > 0 ? pixels_.at(x, y).plane.dot(p) : 0;
    if (share[i] > share[nearest]) nearest = i;
  }
  if (!(share[nearest] > 0)) return {};
  const SurfacePixel& pixel = pixels_.at(quad.x + (nearest & 1), quad.y + (nearest >> 1));
  float sum_m = 0;
  float shares = 0;
  for (int i = 0; i < 4; ++i) {
    if (std::abs(distance_m[i] - distance_m[nearest]) > pixel.same_surface_m) continue;
    sum_m += share[i] * distance_m[i];
    shares += share[i];
  }
  return {sum_m / shares, pixel.plane.w(), &pixel};  // shares > 0: the nearest is always in
}

Sighting Observation::sight(const Eigen::Vector3f& p_camera) const {
  if (!(p_camera.z() > 0)) return {};
  const float u = camera_.fx * p_camera.x() / p_camera.z() + camera_.cx;
  const float v = camera_.fy * p_camera.y() / p_camera.z() + camera_.cy;
  return camera_.sees(u, v) ? sight(p_camera.x(), p_camera.y(), p_camera.z(), u, v) : Sighting{};
}

}  // namespace scanknit
