#include "fusion/observation.h"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "fusion/surface_image.h"
#include "fusion/surface_rows.h"

namespace scanknit {

Observation::Observation(const Frame& frame, const FusionConfig& config) : intrinsics_(frame.intrinsics) {
  prepare_planes(frame, config);
  if (frame.colour) prepare_colour(*frame.colour);
}

void Observation::prepare_planes(const Frame& frame, const FusionConfig& config) {
  const SurfaceImage surface(frame, config.noise);
  const Rays rays(intrinsics_);
  const double least_sigma_m = config.noise.sigma_m(config.noise.from_m);
  const Band band{static_cast<float>(config.truncation_voxels * config.voxel_size_m),
                  static_cast<float>(config.truncation_sigmas), FloatNoise(config.noise),
                  static_cast<float>(least_sigma_m * least_sigma_m)};
  planes_ = Image<PixelPlane>(surface.z_m.width(), surface.z_m.height());
  Image<DepthRange> bands(surface.z_m.width(), surface.z_m.height());
  tbb::parallel_for(0, bands.height(), [&](int y) {
    band_row(surface.z_m.row(y), surface.normals.row(y).data(), y, rays, band, bands.row(y).data(),
             planes_.row(y).data());
  });
  bands_ = DepthPyramid(std::move(bands));
}

void Observation::prepare_colour(const ColourFrame& colour) {
  colour_camera_ = colour.intrinsics;
  T_colour_depth_ = colour.T_colour_depth;
  colours_ = Image<ColourCode>(colour.image.width(), colour.image.height());
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
