#include "fusion/surface_pyramid.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "core/median.h"
#include "fusion/luma.h"
#include "fusion/surface_rows.h"

namespace scanknit {
namespace {

constexpr int kMaxWidth = 400;
constexpr int kLanes = 8;

CameraIntrinsics halved(const CameraIntrinsics& k) {
  return {k.width / 2, k.height / 2, k.fx / 2, k.fy / 2, (k.cx + 0.5) / 2 - 0.5, (k.cy + 0.5) / 2 - 0.5};
}

/// One pixel of a finer picture.
struct Sample {
  float z_m = 0;
  Eigen::Vector3f ray, normal;
  float intensity = -1;
};

/// The mean plane of the samples on the nearest surface, where `ray` meets it.
[[gnu::always_inline]] inline Sample mean_of(const std::array<Sample, 4>& samples, const Eigen::Vector3f& ray,
                                             const NoiseModel& noise) {
  Sample mean;
  mean.ray = ray;
  const Sample* nearest = nullptr;
  for (const Sample& sample : samples) {
    if (sample.z_m > 0 && (nearest == nullptr || sample.z_m < nearest->z_m)) nearest = &sample;
  }
  if (nearest == nullptr) return mean;
  const Eigen::Vector3f p = nearest->ray * nearest->z_m;
  const float same_m = kSameSurfaceSigmas * static_cast<float>(noise.sigma_m(static_cast<double>(nearest->z_m)));
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();
  Eigen::Vector3f point = Eigen::Vector3f::Zero();
  float points = 0, intensity = 0, intensities = 0;
  for (const Sample& sample : samples) {
    const Eigen::Vector3f q = sample.ray * sample.z_m;
    if (!(sample.z_m > 0) || std::abs(nearest->normal.dot(q - p)) > same_m) continue;
    normal += sample.normal;
    point += q;
    points += 1;
    if (sample.intensity < 0) continue;
    intensity += sample.intensity;
    intensities += 1;
  }
  mean.normal = normal.normalized();
  const float slope = mean.normal.dot(ray);
  mean.z_m = slope < -kMinSmoothedSlope ? mean.normal.dot(point) / (points * slope) : nearest->z_m;
  if (!(mean.z_m > 0)) mean.z_m = nearest->z_m;
  if (intensities > 0) mean.intensity = intensity / intensities;
  return mean;
}

void store(const Sample& sample, int x, int y, SurfaceLevel& level) {
  const std::size_t i = level.index(x, y);
  level.intensity[i] = sample.intensity;
  if (!(sample.z_m > 0)) return;
  level.z_m[i] = sample.z_m;
  level.nx[i] = sample.normal.x();
  level.ny[i] = sample.normal.y();
  level.nz[i] = sample.normal.z();
}

/// A level of half the size; `sample(x, y)` reads the finer picture.
template <typename SampleAt>
SurfaceLevel shrink(const CameraIntrinsics& fine, const NoiseModel& noise, SampleAt sample_at) {
  SurfaceLevel coarse(halved(fine));
  const Rays rays(coarse.intrinsics);
  tbb::parallel_for(0, coarse.intrinsics.height, [&](int y) {
    for (int x = 0; x < coarse.intrinsics.width; ++x) {
      const std::array samples{sample_at(2 * x, 2 * y), sample_at(2 * x + 1, 2 * y), sample_at(2 * x, 2 * y + 1),
                               sample_at(2 * x + 1, 2 * y + 1)};
      store(mean_of(samples, rays.at(x, y), noise), x, y, coarse);
    }
  });
  return coarse;
}

SurfaceLevel shrink(const SurfaceLevel& fine, const NoiseModel& noise) {
  return shrink(fine.intrinsics, noise, [&, rays = Rays(fine.intrinsics)](int x, int y) {
    const std::size_t i = fine.index(x, y);
    return Sample{fine.z_m[i], rays.at(x, y), {fine.nx[i], fine.ny[i], fine.nz[i]}, fine.intensity[i]};
  });
}

/// Gradients of the intensity by central differences, across one surface.
void add_gradients(SurfaceLevel& level) {
  const auto difference = [&](std::size_t before, std::size_t after) {
    if (level.intensity[before] < 0 || level.intensity[after] < 0) return 0.0f;
    return 0.5f * (level.intensity[after] - level.intensity[before]);
  };
  const auto stride = static_cast<std::size_t>(level.stride);
  tbb::parallel_for(1, std::max(1, level.intrinsics.height - 1), [&](int y) {
    for (int x = 1; x < level.intrinsics.width - 1; ++x) {
      const std::size_t i = level.index(x, y);
      level.gx[i] = difference(i - 1, i + 1);
      level.gy[i] = difference(i - stride, i + stride);
    }
  });
}

SurfacePyramid finish(SurfaceLevel finest, const NoiseModel& noise) {
  SurfacePyramid pyramid;
  pyramid.levels.push_back(std::move(finest));
  while (pyramid.levels.size() < kPyramidLevels) pyramid.levels.push_back(shrink(pyramid.levels.back(), noise));
  for (SurfaceLevel& level : pyramid.levels) add_gradients(level);
  return pyramid;
}

/// A picture's luma with its camera, in blocks of pixels that are about as large as those of `wanted`.
struct GreyPicture {
  Image<float> pixels;
  CameraIntrinsics intrinsics;
};

GreyPicture grey_of(const ColourFrame& colour, const CameraIntrinsics& wanted) {
  CameraIntrinsics k = colour.intrinsics;
  int side = 1;
  while (std::abs(k.fx) > 1.5 * std::abs(wanted.fx) && k.width > 1 && k.height > 1) {
    k = halved(k);
    side *= 2;
  }
  GreyPicture grey{Image<float>(k.width, k.height), k};
  const float per_sum = 1.0f / (255.0f * static_cast<float>(side) * static_cast<float>(side));
  tbb::parallel_for(0, k.height, [&](int y) {
    for (int x = 0; x < k.width; ++x) {
      unsigned r = 0, g = 0, b = 0;
      for (int row = side * y; row < side * (y + 1); ++row) {
        for (const Rgb8& pixel :
             colour.image.row(row).subspan(static_cast<std::size_t>(side * x), static_cast<std::size_t>(side))) {
          r += pixel.r;
          g += pixel.g;
          b += pixel.b;
        }
      }
      grey.pixels.at(x, y) = per_sum * luma(static_cast<float>(r), static_cast<float>(g), static_cast<float>(b));
    }
  });
  return grey;
}

/// Bilinear; negative outside.
float intensity_at(const Image<float>& picture, float u, float v) {
  if (!(u >= 0 && v >= 0 && u < static_cast<float>(picture.width() - 1) &&
        v < static_cast<float>(picture.height() - 1)))
    return -1;
  const int x = static_cast<int>(u);
  const int y = static_cast<int>(v);
  const float wx = u - static_cast<float>(x);
  const float wy = v - static_cast<float>(y);
  return (1 - wy) * ((1 - wx) * picture.at(x, y) + wx * picture.at(x + 1, y)) +
         wy * ((1 - wx) * picture.at(x, y + 1) + wx * picture.at(x + 1, y + 1));
}

void add_intensities(const ColourFrame& colour, SurfaceLevel& level) {
  const GreyPicture grey = grey_of(colour, level.intrinsics);
  const Rays rays(level.intrinsics);
  const Eigen::Matrix3f R = colour.T_colour_depth.linear().cast<float>();
  const Eigen::Vector3f t = colour.T_colour_depth.translation().cast<float>();
  const CameraIntrinsics& k = grey.intrinsics;
  const auto fx = static_cast<float>(k.fx), fy = static_cast<float>(k.fy);
  const auto cx = static_cast<float>(k.cx), cy = static_cast<float>(k.cy);
  tbb::parallel_for(0, level.intrinsics.height, [&](int y) {
    for (int x = 0; x < level.intrinsics.width; ++x) {
      const std::size_t i = level.index(x, y);
      if (!(level.z_m[i] > 0)) continue;
      const Eigen::Vector3f p = R * (rays.at(x, y) * level.z_m[i]) + t;
      if (p.z() > 0) level.intensity[i] = intensity_at(grey.pixels, fx * p.x() / p.z() + cx, fy * p.y() / p.z() + cy);
    }
  });
}

[[gnu::always_inline]] inline Sample sample_of(const Frame& frame, const Rays& rays, int x, int y) {
  Sample sample{frame.depth_m.at(x, y), rays.at(x, y), Eigen::Vector3f::Zero()};
  if (!frame.normals.empty()) sample.normal = frame.normals.at(x, y);
  if (sample.normal.squaredNorm() == 0) sample.normal = -sample.ray.normalized();
  return sample;
}

/// A picture of level 0's size, taken as it is.
template <typename SampleAt>
SurfaceLevel copy(const CameraIntrinsics& intrinsics, SampleAt sample_at) {
  SurfaceLevel level(intrinsics);
  tbb::parallel_for(0, intrinsics.height, [&](int y) {
    for (int x = 0; x < intrinsics.width; ++x) store(sample_at(x, y), x, y, level);
  });
  return level;
}

int halvings_of(const CameraIntrinsics& k) {
  int halvings = 0;
  while ((k.width >> halvings) > kMaxWidth) ++halvings;
  return halvings;
}

}  // namespace

SurfaceLevel::SurfaceLevel(const CameraIntrinsics& k)
    : intrinsics(k), stride((k.width + kLanes - 1) / kLanes * kLanes) {
  const std::size_t size = static_cast<std::size_t>(stride) * static_cast<std::size_t>(k.height);
  for (auto* plane : {&z_m, &nx, &ny, &nz, &gx, &gy}) plane->assign(size, 0.0f);
  intensity.assign(size, -1.0f);
}

std::size_t points_of(const SurfaceLevel& level) {
  return static_cast<std::size_t>(std::count_if(level.z_m.begin(), level.z_m.end(), [](float z) { return z > 0; }));
}

double median_depth_m(const SurfaceLevel& level) {
  std::vector<float> depths;
  std::copy_if(level.z_m.begin(), level.z_m.end(), std::back_inserter(depths), [](float z) { return z > 0; });
  return double{median(std::move(depths))};
}

CameraIntrinsics tracking_camera(const CameraIntrinsics& depth_camera) {
  CameraIntrinsics k = depth_camera;
  for (int i = 0; i < halvings_of(depth_camera); ++i) k = halved(k);
  return k;
}

SurfacePyramid pyramid_of(const Frame& frame, const NoiseModel& noise) {
  const auto sample_at = [&, rays = Rays(frame.intrinsics)](int x, int y) { return sample_of(frame, rays, x, y); };
  const int halvings = halvings_of(frame.intrinsics);
  SurfaceLevel level = halvings == 0 ? copy(frame.intrinsics, sample_at) : shrink(frame.intrinsics, noise, sample_at);
  for (int i = 1; i < halvings; ++i) level = shrink(level, noise);
  if (frame.colour) add_intensities(*frame.colour, level);
  return finish(std::move(level), noise);
}

SurfacePyramid pyramid_of(const ModelView& view, const NoiseModel& noise) {
  SurfaceLevel level = copy(view.intrinsics, [&, rays = Rays(view.intrinsics)](int x, int y) {
    return Sample{view.depth_m.at(x, y), rays.at(x, y), view.normals.at(x, y), view.intensity.at(x, y)};
  });
  return finish(std::move(level), noise);
}

}  // namespace scanknit
