#include "fusion/observation.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace scanknit {
namespace {

// Beyond this the tangent plane says little of the distance along the ray; the band is not widened any further.
constexpr float kMinSlope = 0.25f;

// A neighbouring pixel whose plane disagrees by more than this share of the truncation shows another surface.
constexpr float kSameSurfaceShare = 0.5f;

struct PictureCamera {
  float fx, fy, cx, cy;
  explicit PictureCamera(const CameraIntrinsics& k)
      : fx(static_cast<float>(k.fx)),
        fy(static_cast<float>(k.fy)),
        cx(static_cast<float>(k.cx)),
        cy(static_cast<float>(k.cy)) {}
};

/// The four pixels round (u, v) and the share of the first in each direction.
struct Bilinear {
  int x, y;
  float wx, wy;

  Bilinear(float u, float v) {
    const float fu = std::floor(u);
    const float fv = std::floor(v);
    x = static_cast<int>(fu);
    y = static_cast<int>(fv);
    wx = 1.0f - (u - fu);
    wy = 1.0f - (v - fv);
  }
  [[nodiscard]] float weight(int i) const { return ((i & 1) != 0 ? 1.0f - wx : wx) * ((i & 2) != 0 ? 1.0f - wy : wy); }
};

/// True for coordinates that round to a pixel of the picture; false for NaN.
bool is_inside(float u, float v, int width, int height) {
  return u >= -0.5f && v >= -0.5f && u < static_cast<float>(width) - 0.5f && v < static_cast<float>(height) - 0.5f;
}

}  // namespace

Observation::Observation(const Frame& frame, const FusionConfig& config)
    : intrinsics_(frame.intrinsics),
      planes_(frame.depth_m.width(), frame.depth_m.height()),
      trust_(frame.depth_m.width(), frame.depth_m.height()) {
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

      planes_.at(x, y) = {normal, offset_m};
      trust_.at(x, y) = {cosine * static_cast<float>(best_variance / (sigma_m * sigma_m)), truncation_m};
      bands.at(x, y) = {depth_m - truncation_m / slope, depth_m + truncation_m / slope};
    }
  };
  tbb::parallel_for(tbb::blocked_range<int>(0, planes_.height(), 16), [&](const tbb::blocked_range<int>& rows) {
    for (int y = rows.begin(); y < rows.end(); ++y) prepare_row(y);
  });
  bands_ = DepthPyramid(std::move(bands));

  if (frame.colour && !frame.colour->image.empty()) {
    colour_ = &*frame.colour;
    R_colour_depth_ = colour_->T_colour_depth.linear().cast<float>();
    t_colour_depth_ = colour_->T_colour_depth.translation().cast<float>();
  }
}

std::optional<Sighting> Observation::sight(const Eigen::Vector3f& p_camera) const {
  if (!(p_camera.z() > 0)) return std::nullopt;
  const PictureCamera camera(intrinsics_);
  const float u = camera.fx * p_camera.x() / p_camera.z() + camera.cx;
  const float v = camera.fy * p_camera.y() / p_camera.z() + camera.cy;
  if (!is_inside(u, v, planes_.width(), planes_.height())) return std::nullopt;

  const Bilinear pixels(u, v);
  std::array<float, 4> share{};
  std::array<float, 4> distance_m{};
  int nearest = -1;
  for (int i = 0; i < 4; ++i) {
    const int x = pixels.x + (i & 1);
    const int y = pixels.y + (i >> 1);
    if (!planes_.contains(x, y)) continue;
    const PixelPlane& plane = planes_.at(x, y);
    if (plane.offset_m == 0) continue;
    const auto at = static_cast<std::size_t>(i);
    share[at] = pixels.weight(i);
    distance_m[at] = plane.normal.dot(p_camera) - plane.offset_m;
    if (share[at] > 0 && (nearest < 0 || share[at] > share[static_cast<std::size_t>(nearest)])) nearest = i;
  }
  if (nearest < 0) return std::nullopt;

  const PixelTrust& trust = trust_.at(pixels.x + (nearest & 1), pixels.y + (nearest >> 1));
  const float reference_m = distance_m[static_cast<std::size_t>(nearest)];
  float sum_m = 0;
  float shares = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    if (share[i] == 0 || std::abs(distance_m[i] - reference_m) > kSameSurfaceShare * trust.truncation_m) continue;
    sum_m += share[i] * distance_m[i];
    shares += share[i];
  }
  return Sighting{sum_m / shares, trust.truncation_m, trust.weight};  // shares > 0: the nearest is always in
}

std::optional<Eigen::Vector3f> Observation::colour_at(const Eigen::Vector3f& p_camera) const {
  const Eigen::Vector3f p_colour = R_colour_depth_ * p_camera + t_colour_depth_;
  if (!(p_colour.z() > 0)) return std::nullopt;
  const PictureCamera camera(colour_->intrinsics);
  const ColourImage& image = colour_->image;
  const float u = camera.fx * p_colour.x() / p_colour.z() + camera.cx;
  const float v = camera.fy * p_colour.y() / p_colour.z() + camera.cy;
  if (!is_inside(u, v, image.width(), image.height())) return std::nullopt;

  const Bilinear pixels(u, v);
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (int i = 0; i < 4; ++i) {
    const int x = std::clamp(pixels.x + (i & 1), 0, image.width() - 1);
    const int y = std::clamp(pixels.y + (i >> 1), 0, image.height() - 1);
    const Rgb8 pixel = image.at(x, y);
    sum += pixels.weight(i) * Eigen::Vector3f(pixel.r, pixel.g, pixel.b);
  }
  return Eigen::Vector3f(sum / 255.0f);
}

}  // namespace scanknit
