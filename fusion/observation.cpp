#include "fusion/observation.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace scanknit {
namespace {

// Beyond this the tangent plane says little of the distance along the ray; the band is not widened any further.
constexpr float kMinSlope = 0.25f;

// A neighbouring pixel off another's plane by more than this share of the truncation shows another surface.
constexpr float kSameSurfaceShare = 0.5f;

}  // namespace

Observation::Observation(const Frame& frame, const FusionConfig& config)
    : intrinsics_(frame.intrinsics),
      camera_(frame.intrinsics),
      planes_(frame.depth_m.width(), frame.depth_m.height(), PixelPlane::Zero()),
      trust_(frame.depth_m.width(), frame.depth_m.height()),
      smooth_(frame.depth_m.width(), frame.depth_m.height()) {
  Image<DepthRange> bands(planes_.width(), planes_.height());
  const double voxels_m = config.truncation_voxels * config.voxel_size_m;
  const double best_variance = config.noise.sigma_m(config.noise.from_m) * config.noise.sigma_m(config.noise.from_m);

  const auto prepare_row = [&](int y) {
    for (int x = 0; x < planes_.width(); ++x) {
      const float depth_m = frame.depth_m.at(x, y);
      if (!(depth_m > 0)) continue;
      const Eigen::Vector3f p = intrinsics_.unproject(x, y, static_cast<double>(depth_m)).cast<float>();
      Eigen::Vector3f normal = frame.normals.empty() ? Eigen::Vector3f::Zero() : frame.normals.at(x, y);
      if (normal.squaredNorm() == 0) normal = -p.normalized();  // unknown: as if seen head-on
      const float offset_m = normal.dot(p);                     // negative: the camera is in front of the plane

      const double sigma_m = config.noise.sigma_m(static_cast<double>(depth_m));
      const auto truncation_m = static_cast<float>(std::max(voxels_m, config.truncation_sigmas * sigma_m));
      const float cosine = std::clamp(-offset_m / p.norm(), 0.0f, 1.0f);
      const float slope = std::max(-offset_m / depth_m, kMinSlope);  // distance to the plane per unit of z

      planes_.at(x, y) << normal, offset_m;
      trust_.at(x, y) = {cosine * static_cast<float>(best_variance / (sigma_m * sigma_m)), truncation_m};
      bands.at(x, y) = {depth_m - truncation_m / slope, depth_m + truncation_m / slope};
    }
  };
  tbb::parallel_for(0, planes_.height(), prepare_row);
  tbb::parallel_for(0, planes_.height(), [&](int y) {
    for (int x = 0; x < planes_.width(); ++x) smooth_.at(x, y) = is_smooth(x, y) ? 1 : 0;
  });
  bands_ = DepthPyramid(std::move(bands));

  if (frame.colour && !frame.colour->image.empty()) {
    colour_ = &*frame.colour;
    colour_camera_ = PictureCamera(colour_->intrinsics);
    R_colour_depth_ = colour_->T_colour_depth.linear().cast<float>();
    t_colour_depth_ = colour_->T_colour_depth.translation().cast<float>();
  }
}

bool Observation::is_smooth(int x, int y) const {
  for (int i = 0; i < 4; ++i) {
    if (!has_return(x + (i & 1), y + (i >> 1))) return false;
  }
  // Each pixel's point on its own ray, against the plane of the pixel diagonally across.
  for (int i = 0; i < 4; ++i) {
    const int px = x + (i & 1);
    const int py = y + (i >> 1);
    const PixelPlane& own = planes_.at(px, py);
    const PixelPlane& across = planes_.at(x + 1 - (i & 1), y + 1 - (i >> 1));
    const Eigen::Vector3f ray((static_cast<float>(px) - camera_.cx) / camera_.fx,
                              (static_cast<float>(py) - camera_.cy) / camera_.fy, 1);
    const Eigen::Vector3f p = ray * (own.w() / own.head<3>().dot(ray));
    const float step_m = across.head<3>().dot(p) - across.w();
    if (!(std::abs(step_m) <= kSameSurfaceShare * trust_.at(px, py).truncation_m)) return false;
  }
  return true;
}

int Observation::nearest_return(const Bilinear& pixels) const {
  int best = -1;
  for (int i = 0; i < 4; ++i) {
    if (pixels.share(i) > 0 && (best < 0 || pixels.share(i) > pixels.share(best)) &&
        has_return(pixels.x + (i & 1), pixels.y + (i >> 1))) {
      best = i;
    }
  }
  return best;
}

std::optional<Sighting> Observation::sight_rough(const Eigen::Vector4f& p, const Bilinear& pixels) const {
  const int nearest = nearest_return(pixels);
  if (nearest < 0) return std::nullopt;
  const int nearest_x = pixels.x + (nearest & 1);
  const int nearest_y = pixels.y + (nearest >> 1);
  const PixelTrust& trust = trust_.at(nearest_x, nearest_y);
  const float reference_m = planes_.at(nearest_x, nearest_y).dot(p);
  float sum_m = 0;
  float shares = 0;
  for (int i = 0; i < 4; ++i) {
    const int x = pixels.x + (i & 1);
    const int y = pixels.y + (i >> 1);
    if (!has_return(x, y)) continue;
    const float distance_m = planes_.at(x, y).dot(p);
    if (std::abs(distance_m - reference_m) > kSameSurfaceShare * trust.truncation_m) continue;
    sum_m += pixels.share(i) * distance_m;
    shares += pixels.share(i);
  }
  return Sighting{sum_m / shares, trust.truncation_m, trust.weight};  // shares > 0: the nearest is always in
}

std::optional<Eigen::Vector3f> Observation::colour_at(const Eigen::Vector3f& p_camera) const {
  const Eigen::Vector3f p_colour = R_colour_depth_ * p_camera + t_colour_depth_;
  if (!(p_colour.z() > 0)) return std::nullopt;
  const float u = colour_camera_.u(p_colour);
  const float v = colour_camera_.v(p_colour);
  if (!colour_camera_.sees(u, v)) return std::nullopt;
  const ColourImage& image = colour_->image;

  const Bilinear pixels(u, v);
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (int i = 0; i < 4; ++i) {
    const int x = std::clamp(pixels.x + (i & 1), 0, image.width() - 1);
    const int y = std::clamp(pixels.y + (i >> 1), 0, image.height() - 1);
    const Rgb8 pixel = image.at(x, y);
    sum += pixels.share(i) * Eigen::Vector3f(pixel.r, pixel.g, pixel.b);
  }
  return Eigen::Vector3f(sum / 255.0f);
}

}  // namespace scanknit
