#include "export/texture/posed_picture.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "export/picture/with_opencv.h"
#include "export/texture/srgb.h"

namespace scanknit {
namespace {

constexpr float kGrazing = 0.2f;        // cosine; flatter than that a pixel covers too much of the surface
constexpr float kLeastClear_px = 1.5f;  // beside a step colour and depth need not belong together
constexpr float kWellClear_px = 8;
constexpr float kStepBands = 2;       // three noisy readings make a bend of some more than one is off
constexpr float kWellInside = 0.05f;  // of the picture's width, from its border

const std::array<float, 256>& linear_table() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> made{};
    for (std::size_t i = 0; i < made.size(); ++i) {
      made[i] = static_cast<float>(linear_from_srgb(static_cast<std::uint8_t>(i)));
    }
    return made;
  }();
  return table;
}

bool sees_as_depth_does(const Frame& frame) {
  const ColourFrame& colour = *frame.colour;
  return colour.intrinsics == frame.intrinsics && colour.T_colour_depth.isApprox(Pose::Identity(), 1e-9);
}

/// The nearest reading at each pixel of `camera`. Readings are spread so far that neighbours leave no gaps.
Image<float> depth_seen_by(const CameraIntrinsics& camera, const Frame& frame) {
  Image<float> seen(camera.width, camera.height, 0);
  const Pose& T_colour_depth = frame.colour->T_colour_depth;
  const double spread = std::max(std::abs(camera.fx / frame.intrinsics.fx), std::abs(camera.fy / frame.intrinsics.fy));
  const int reach = std::clamp(static_cast<int>(std::ceil(spread / 2)), 1, 4);
  for (int y = 0; y < frame.depth_m.height(); ++y) {
    for (int x = 0; x < frame.depth_m.width(); ++x) {
      const float depth_m = frame.depth_m.at(x, y);
      if (!(depth_m > 0)) continue;
      const Eigen::Vector3d p = T_colour_depth * frame.intrinsics.unproject(x, y, depth_m);
      if (!(p.z() > 0)) continue;
      const Eigen::Vector2d pixel = camera.project(p);
      if (!(std::abs(pixel.x()) < 1e6 && std::abs(pixel.y()) < 1e6)) continue;
      const int u0 = static_cast<int>(std::floor(pixel.x() + 0.5)), v0 = static_cast<int>(std::floor(pixel.y() + 0.5));
      for (int v = v0 - reach; v <= v0 + reach; ++v) {
        for (int u = u0 - reach; u <= u0 + reach; ++u) {
          if (!seen.contains(u, v)) continue;
          float& nearest_m = seen.at(u, v);
          const auto z = static_cast<float>(p.z());
          if (nearest_m == 0 || z < nearest_m) nearest_m = z;
        }
      }
    }
  }
  return seen;
}

/// The colour camera at about the resolution of the depth picture.
CameraIntrinsics thinned(const CameraIntrinsics& colour, const CameraIntrinsics& depth) {
  if (colour.width <= depth.width) return colour;
  const double share = static_cast<double>(depth.width) / colour.width;
  return colour.resized(depth.width, std::max(1, static_cast<int>(std::lround(colour.height * share))));
}

}  // namespace

PosedPicture::PosedPicture(const Frame& frame, const Pose& T_world_camera, const FitBand& band)
    : picture_(frame.colour->image),
      camera_(frame.colour->intrinsics),
      least_band_m_(static_cast<float>(band.least_m)),
      sigmas_(static_cast<float>(band.sigmas)),
      noise_(band.noise),
      T_colour_world_(frame.colour->T_colour_depth * T_world_camera.inverse()) {
  see_depth(frame);
  with_opencv([this] {
    fill_small_holes();
    measure_clearance();
  });
}

void PosedPicture::see_depth(const Frame& frame) {
  const bool is_registered = sees_as_depth_does(frame);
  depth_camera_ = is_registered ? frame.intrinsics : thinned(camera_, frame.intrinsics);
  depth_m_ = is_registered ? frame.depth_m : depth_seen_by(depth_camera_, frame);
}

/// Registered depth has pinholes, and some sensors leave out pixels here and there: the nearest of their surroundings.
void PosedPicture::fill_small_holes() {
  constexpr float kNothing = 1e30f;
  const int width = depth_m_.width(), height = depth_m_.height();
  cv::Mat known(height, width, CV_32F), nearest;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) known.at<float>(y, x) = depth_m_.at(x, y) > 0 ? depth_m_.at(x, y) : kNothing;
  }
  cv::erode(known, nearest, cv::Mat::ones(5, 5, CV_8U), cv::Point(-1, -1), 1, cv::BORDER_REPLICATE);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (!(depth_m_.at(x, y) > 0) && nearest.at<float>(y, x) < kNothing) depth_m_.at(x, y) = nearest.at<float>(y, x);
    }
  }
}

/// A step is where depth bends by more than the band between one pixel and the next: a slope, however steep, is none.
void PosedPicture::measure_clearance() {
  const int width = depth_m_.width(), height = depth_m_.height();
  cv::Mat is_smooth(height, width, CV_8U, cv::Scalar(0));
  for (int y = 1; y + 1 < height; ++y) {
    for (int x = 1; x + 1 < width; ++x) {
      const float here = depth_m_.at(x, y), step_m = kStepBands * band_m(here);
      const float left = depth_m_.at(x - 1, y), right = depth_m_.at(x + 1, y);
      const float above = depth_m_.at(x, y - 1), below = depth_m_.at(x, y + 1);
      const bool is_known = here > 0 && left > 0 && right > 0 && above > 0 && below > 0;
      const bool bends = std::abs(left + right - 2 * here) > step_m || std::abs(above + below - 2 * here) > step_m;
      is_smooth.at<std::uint8_t>(y, x) = is_known && !bends ? 1 : 0;
    }
  }
  clearance_px_ = Image<float>(width, height, 0);
  cv::Mat clearance(height, width, CV_32F, clearance_px_.pixels().data());
  cv::distanceTransform(is_smooth, clearance, cv::DIST_L2, cv::DIST_MASK_5, CV_32F);
}

/// How far a point may be from the depth of its pixel.
float PosedPicture::band_m(float depth_m) const {
  return std::max(least_band_m_, sigmas_ * static_cast<float>(noise_.sigma_m(static_cast<double>(depth_m))));
}

unsigned PosedPicture::out_of_sight(const Eigen::Vector3f& p, const Eigen::Vector3f& normal) const {
  constexpr unsigned kFacesAway = 1, kBehind = 2, kLeft = 4, kRight = 8, kAbove = 16, kBelow = 32;
  const float x = static_cast<float>(camera_.fx) * p.x() + static_cast<float>(camera_.cx) * p.z();
  const float y = static_cast<float>(camera_.fy) * p.y() + static_cast<float>(camera_.cy) * p.z();
  // Half planes through the camera, which are right behind it, too.
  return (p.dot(normal) >= 0 ? kFacesAway : 0) | (p.z() <= 0 ? kBehind : 0) | (x < 0 ? kLeft : 0) |
         (x > static_cast<float>(picture_.width() - 1) * p.z() ? kRight : 0) | (y < 0 ? kAbove : 0) |
         (y > static_cast<float>(picture_.height() - 1) * p.z() ? kBelow : 0);
}

std::optional<PosedPicture::Sight> PosedPicture::look_at(const Eigen::Vector3f& p,
                                                         const Eigen::Vector3f& normal) const {
  if (!(p.z() > 0)) return std::nullopt;
  const float cosine = -p.dot(normal) / std::sqrt(p.squaredNorm() * normal.squaredNorm());
  if (!(cosine > kGrazing)) return std::nullopt;  // also NaN
  const float inverse_z = 1 / p.z();
  const float fx = static_cast<float>(camera_.fx), fy = static_cast<float>(camera_.fy);
  const float x = fx * p.x() * inverse_z + static_cast<float>(camera_.cx);
  const float y = fy * p.y() * inverse_z + static_cast<float>(camera_.cy);
  const float inside = std::min(std::min(x, static_cast<float>(picture_.width() - 1) - x),
                                std::min(y, static_cast<float>(picture_.height() - 1) - y));
  if (!(inside > 0)) return std::nullopt;
  const float u = static_cast<float>(depth_camera_.fx) * p.x() * inverse_z + static_cast<float>(depth_camera_.cx);
  const float v = static_cast<float>(depth_camera_.fy) * p.y() * inverse_z + static_cast<float>(depth_camera_.cy);
  const int column = static_cast<int>(u + 0.5f), row = static_cast<int>(v + 0.5f);
  if (!depth_m_.contains(column, row)) return std::nullopt;
  const float clearance_px = clearance_px_.at(column, row);
  if (!(clearance_px > kLeastClear_px)) return std::nullopt;
  const float depth_m = depth_m_.at(column, row);
  if (!(std::abs(depth_m - p.z()) <= band_m(depth_m))) return std::nullopt;
  const float clear = std::min((clearance_px - kLeastClear_px) / (kWellClear_px - kLeastClear_px), 1.0f);
  const float centred = std::min(inside / (kWellInside * static_cast<float>(picture_.width())), 1.0f);
  const float head_on = (cosine - kGrazing) / (1 - kGrazing);  // none at the angle from which on nothing is seen
  return Sight{x, y, std::abs(fx * fy) * inverse_z * inverse_z * head_on * clear * centred};
}

LinearColour PosedPicture::colour(const Sight& sight) const {
  const int x = std::clamp(static_cast<int>(sight.x), 0, picture_.width() - 1);
  const int y = std::clamp(static_cast<int>(sight.y), 0, picture_.height() - 1);
  const int right = std::min(x + 1, picture_.width() - 1), below = std::min(y + 1, picture_.height() - 1);
  const float s = sight.x - static_cast<float>(x), t = sight.y - static_cast<float>(y);
  const std::array<float, 256>& linear = linear_table();
  const Rgb8 a = picture_.at(x, y), b = picture_.at(right, y), c = picture_.at(x, below), d = picture_.at(right, below);
  const auto mix = [&](std::uint8_t va, std::uint8_t vb, std::uint8_t vc, std::uint8_t vd) {
    const float upper = linear[va] + s * (linear[vb] - linear[va]);
    const float lower = linear[vc] + s * (linear[vd] - linear[vc]);
    return upper + t * (lower - upper);
  };
  return {mix(a.r, b.r, c.r, d.r), mix(a.g, b.g, c.g, d.g), mix(a.b, b.b, c.b, d.b)};
}

}  // namespace scanknit
