#include "fusion/observation.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace scanknit {
namespace {

// In front of a slanted surface the band is longer along the ray than across it, up to this slope.
constexpr float kMinSlope = 0.25f;

}  // namespace

Observation::Observation(const Frame& frame, const FusionConfig& config)
    : intrinsics_(frame.intrinsics), surface_(frame, config.noise) {
  prepare_bands(config);
  if (frame.colour) prepare_colour(*frame.colour);
}

void Observation::prepare_bands(const FusionConfig& config) {
  const double voxels_m = config.truncation_voxels * config.voxel_size_m;
  Image<DepthRange> bands(surface_.z_m.width(), surface_.z_m.height());
  tbb::parallel_for(0, bands.height(), [&](int y) {
    for (int x = 0; x < bands.width(); ++x) {
      const float z_m = surface_.z_m.at(x, y);
      if (!(z_m > 0)) continue;
      const double sigma_m = config.noise.sigma_m(static_cast<double>(z_m));
      const auto truncation_m = static_cast<float>(std::max(voxels_m, config.truncation_sigmas * sigma_m));
      const Eigen::Vector3f ray = intrinsics_.unproject(x, y, 1).cast<float>();
      const float slope = std::max(-unpack(surface_.normals.at(x, y)).dot(ray), kMinSlope);
      bands.at(x, y) = {z_m - truncation_m / slope, z_m + truncation_m};
    }
  });
  bands_ = DepthPyramid(std::move(bands));
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

}  // namespace scanknit
