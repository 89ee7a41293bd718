#include "fusion/register/surface_pyramid.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "core/median.h"
#include "fusion/integrate/surface_rows.h"
#include "fusion/register/luma.h"
#include "fusion/register/pyramid_rows.h"

namespace scanknit {
namespace {

constexpr int kMaxWidth = 400;

CameraIntrinsics halved(const CameraIntrinsics& k) {
  return {k.width / 2, k.height / 2, k.fx / 2, k.fy / 2, (k.cx + 0.5) / 2 - 0.5, (k.cy + 0.5) / 2 - 0.5};
}

constexpr int padded(int width) {
  return (width + kPixelGroup - 1) / kPixelGroup * kPixelGroup;
}

/// Rows of a finer level; the numbers after a row's end mean nothing.
class LevelRows {
 public:
  explicit LevelRows(const SurfaceLevel& level) : level_(level) {}
  [[nodiscard]] PlaneRow<const float> row(int y, int /*which*/) {
    const std::size_t i = level_.index(0, y);
    return {&level_.z_m[i], &level_.nx[i], &level_.ny[i], &level_.nz[i], &level_.intensity[i]};
  }

 private:
  const SurfaceLevel& level_;
};

/// Rows of a frame: two of them at hand, upper and lower.
class FrameRows {
 public:
  explicit FrameRows(const Frame& frame)
      : frame_(frame), rays_(frame.intrinsics), width_(2 * kPixelGroup + padded(frame.depth_m.width())) {
    normals_.assign(width_, Eigen::Vector3f::Zero());
    numbers_.assign(2 * 4 * width_, 0.0f);
  }
  [[nodiscard]] PlaneRow<const float> row(int y, int which) {
    float* z_m = numbers_.data() + static_cast<std::size_t>(4 * which) * width_;
    float *nx = z_m + width_, *ny = nx + width_, *nz = ny + width_;
    std::copy(frame_.depth_m.row(y).begin(), frame_.depth_m.row(y).end(), z_m);
    if (!frame_.normals.empty())
      std::copy(frame_.normals.row(y).begin(), frame_.normals.row(y).end(), normals_.begin());
    split_normals(normals_.data(), rays_, frame_.depth_m.width(), y, nx, ny, nz);
    return {z_m, nx, ny, nz, nullptr};
  }

 private:
  const Frame& frame_;
  Rays rays_;
  std::size_t width_;
  std::vector<Eigen::Vector3f> normals_;
  std::vector<float> numbers_;
};

/// A level of half the size.
template <typename Rows, typename Picture>
SurfaceLevel shrink(const CameraIntrinsics& fine, const NoiseModel& noise, const Picture& picture) {
  SurfaceLevel coarse(halved(fine));
  const Rays fine_rays(fine), coarse_rays(coarse.intrinsics);
  const FloatNoise noise_in_float(noise);
  const int width = coarse.intrinsics.width;
  tbb::parallel_for(tbb::blocked_range<int>(0, coarse.intrinsics.height), [&](const tbb::blocked_range<int>& range) {
    Rows rows(picture);
    for (int y = range.begin(); y != range.end(); ++y) {
      const std::size_t i = coarse.index(0, y);
      const PlaneRow<float> row{&coarse.z_m[i], &coarse.nx[i], &coarse.ny[i], &coarse.nz[i], &coarse.intensity[i]};
      shrink_rows(rows.row(2 * y, 0), rows.row(2 * y + 1, 1), fine_rays, coarse_rays, noise_in_float, width, y, row);
      for (float* numbers : {row.z_m, row.nx, row.ny, row.nz})
        std::fill(numbers + width, numbers + coarse.stride, 0.0f);
      std::fill(row.intensity + width, row.intensity + coarse.stride, -1.0f);
    }
  });
  return coarse;
}

SurfaceLevel shrink(const SurfaceLevel& fine, const NoiseModel& noise) {
  return shrink<LevelRows>(fine.intrinsics, noise, fine);
}

/// A frame or view of level 0's size, taken as it is.
template <typename Intensity>
SurfaceLevel copy(const CameraIntrinsics& intrinsics, const DepthImage& depth_m, const Image<Eigen::Vector3f>& normals,
                  Intensity intensity) {
  SurfaceLevel level(intrinsics);
  const Rays rays(intrinsics);
  tbb::parallel_for(0, intrinsics.height, [&](int y) {
    for (int x = 0; x < intrinsics.width; ++x) {
      const std::size_t i = level.index(x, y);
      level.intensity[i] = intensity(x, y);
      if (!(depth_m.at(x, y) > 0)) continue;
      Eigen::Vector3f normal = Eigen::Vector3f::Zero();
      if (!normals.empty()) normal = normals.at(x, y);
      if (normal.squaredNorm() == 0) normal = -rays.at(x, y).normalized();
      level.z_m[i] = depth_m.at(x, y);
      level.nx[i] = normal.x();
      level.ny[i] = normal.y();
      level.nz[i] = normal.z();
    }
  });
  return level;
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

void add_intensities(const ColourFrame& colour, const SteadyMotion& to_colour, SurfaceLevel& level) {
  const GreyPicture grey = grey_of(colour, level.intrinsics);
  const Rays rays(level.intrinsics);
  const Pose T_colour_depth = colour.T_colour_depth * to_colour.after(1).inverse();
  const Eigen::Matrix3f R = T_colour_depth.linear().cast<float>();
  const Eigen::Vector3f t = T_colour_depth.translation().cast<float>();
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

int halvings_of(const CameraIntrinsics& k) {
  int halvings = 0;
  while ((k.width >> halvings) > kMaxWidth) ++halvings;
  return halvings;
}

}  // namespace

SurfaceLevel::SurfaceLevel(const CameraIntrinsics& k) : intrinsics(k), stride(padded(k.width)) {
  const std::size_t size = static_cast<std::size_t>(stride) * static_cast<std::size_t>(k.height) + kPixelGroup;
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

SurfacePyramid pyramid_of(const Frame& frame, const NoiseModel& noise, const SteadyMotion& to_colour) {
  const int halvings = halvings_of(frame.intrinsics);
  SurfaceLevel level = halvings == 0
                           ? copy(frame.intrinsics, frame.depth_m, frame.normals, [](int, int) { return -1.0f; })
                           : shrink<FrameRows>(frame.intrinsics, noise, frame);
  for (int i = 1; i < halvings; ++i) level = shrink(level, noise);
  if (frame.colour) add_intensities(*frame.colour, to_colour, level);
  return finish(std::move(level), noise);
}

SurfacePyramid pyramid_of(const ModelView& view, const NoiseModel& noise) {
  return finish(
      copy(view.intrinsics, view.depth_m, view.normals, [&](int x, int y) { return view.intensity.at(x, y); }), noise);
}

}  // namespace scanknit
