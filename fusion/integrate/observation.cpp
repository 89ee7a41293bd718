#include "fusion/integrate/observation.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "fusion/integrate/masked_pixels.h"
#include "fusion/integrate/surface_image.h"
#include "fusion/integrate/surface_rows.h"

namespace scanknit {
namespace {

/// Noise moves outlines by a pixel or so, and projections are rounded to the nearest: so far from an outline the
/// farther surface says nothing of the space before the nearer one.
constexpr int kOutlinePixels = 2;

/// A surface is as near as this by chance about never.
constexpr float kClearSigmas = 5;

float least_of_five(float a, float b, float c, float d, float e) {
  return std::min(std::min(std::min(a, b), std::min(c, d)), e);
}

}  // namespace

Observation::Observation(const Frame& frame, const FusionConfig& config) : intrinsics_(frame.intrinsics) {
  prepare_planes(frame, config);
  if (frame.colour) prepare_colour(*frame.colour);
}

void Observation::prepare_planes(const Frame& frame, const FusionConfig& config) {
  SurfaceImage surface(frame, config.noise);
  const Rays rays(intrinsics_);
  const MaskedPixels masked(frame, config.carve_free_space);
  const double least_sigma_m = config.noise.sigma_m(config.noise.from_m);
  const Band band{static_cast<float>(config.truncation_voxels * config.voxel_size_m),
                  static_cast<float>(config.truncation_sigmas), FloatNoise(config.noise),
                  static_cast<float>(least_sigma_m * least_sigma_m)};
  planes_ = Image<PixelPlane>::uninitialised(surface.z_m.width(), surface.z_m.height());
  DepthRanges bands = DepthRanges::uninitialised(surface.z_m.width(), surface.z_m.height());
  tbb::parallel_for(0, bands.height(), [&](int y) {
    masked.add_outside(y, rays, surface);
    band_row(surface.z_m.row(y), surface.normals.row(y).data(), y, rays, band, bands, planes_.row(y).data());
    masked.weigh(y, bands, planes_.row(y));
  });
  if (config.carve_free_space) prepare_clearance(surface.z_m, bands, config.noise);
  bands_ = DepthPyramid(std::move(bands));
}

void Observation::prepare_clearance(const Image<float>& z_m, const DepthRanges& bands, const NoiseModel& noise) {
  static_assert(kOutlinePixels == 2);
  const FloatNoise sigma(noise);
  const int width = z_m.width();
  const int height = z_m.height();
  auto along_rows = Image<float>::uninitialised(width, height);
  tbb::parallel_for(tbb::blocked_range<int>(0, height), [&](const auto& rows) {
    std::vector<float> own(static_cast<std::size_t>(width) + 2 * kOutlinePixels, DepthRange{}.near_m);
    for (int y = rows.begin(); y < rows.end(); ++y) {
      const auto z = z_m.row(y);
      const float* const near_m = bands.near_m(y);
      const float* const far_m = bands.far_m(y);
      const auto row = along_rows.row(y);
      for (std::size_t x = 0; x < row.size(); ++x) {
        const float before_band = std::min(near_m[x], far_m[x]);  // the latter of a MaskedPixels' outside
        const float clear = std::min(before_band, z[x] - kClearSigmas * sigma.sigma_m(z[x]));
        own[x + kOutlinePixels] = z[x] > 0 ? clear : 0;
      }
      for (std::size_t x = 0; x < row.size(); ++x)
        row[x] = least_of_five(own[x], own[x + 1], own[x + 2], own[x + 3], own[x + 4]);
    }
  });
  clear_m_ = Image<float>::uninitialised(width, height);
  tbb::parallel_for(0, height, [&](int y) {
    const auto row = [&](int off) { return std::as_const(along_rows).row(std::clamp(y + off, 0, height - 1)); };
    const auto a = row(-2), b = row(-1), c = row(0), d = row(1), e = row(2);
    const auto clear = clear_m_.row(y);
    for (std::size_t x = 0; x < clear.size(); ++x) clear[x] = least_of_five(a[x], b[x], c[x], d[x], e[x]);
  });
}

void Observation::prepare_colour(const ColourFrame& colour) {
  colour_camera_ = colour.intrinsics;
  T_colour_depth_ = colour.T_colour_depth;
  colours_ = Image<std::uint32_t>::uninitialised(colour.image.width(), colour.image.height());
  tbb::parallel_for(0, colours_.height(), [&](int y) {
    const auto from = colour.image.row(y);
    std::transform(from.begin(), from.end(), colours_.row(y).begin(),
                   [](const Rgb8& pixel) { return encode_colour(pixel, 0); });
  });
}

ColourView Observation::colours(std::uint32_t number) const {
  ColourView view;
  if (!colour_camera_) return view;
  view.pixels = colours_.pixels().data();
  view.width = colours_.width();
  view.height = colours_.height();
  view.fx = static_cast<float>(colour_camera_->fx);
  view.fy = static_cast<float>(colour_camera_->fy);
  view.cx = static_cast<float>(colour_camera_->cx);
  view.cy = static_cast<float>(colour_camera_->cy);
  for (std::size_t row = 0; row < 3; ++row) {
    const auto at = static_cast<Eigen::Index>(row);
    for (std::size_t column = 0; column < 3; ++column)
      view.R[3 * row + column] = static_cast<float>(T_colour_depth_.linear()(at, static_cast<Eigen::Index>(column)));
    view.t[row] = static_cast<float>(T_colour_depth_.translation()[at]);
  }
  view.seed = number * 0x9E3779B9u;
  return view;
}

}  // namespace scanknit
