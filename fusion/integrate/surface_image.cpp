#include "fusion/integrate/surface_image.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>

#include "fusion/integrate/surface_rows.h"

namespace scanknit {
namespace {

class Planes {
 public:
  Planes(const Frame& frame, const NoiseModel& noise)
      : depth_m_(frame.depth_m), normals_(frame.normals), rays_(frame.intrinsics), noise_(noise) {}

  /// Fills one pixel that has a return.
  void smooth(int x, int y, float& z_m, Eigen::Vector3f& plane_normal) const {
    const float depth_m = depth_m_.at(x, y);
    const Eigen::Vector3f ray = rays_.at(x, y);
    const Eigen::Vector3f normal = normal_at(x, y, ray);
    plane_normal = normal;
    const float slope = normal.dot(ray);  // negative: the normal points to the camera
    if (!(slope < -kMinSmoothedSlope)) {
      z_m = depth_m;
      return;
    }
    const float offset_m = slope * depth_m;
    const float same_m = same_surface_m(depth_m);
    float sum_m = 0;
    float weights = 0;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if (!depth_m_.contains(x + dx, y + dy)) continue;
        const float other_m = depth_m_.at(x + dx, y + dy);
        const float off_m = normal.dot(rays_.at(x + dx, y + dy)) * other_m - offset_m;
        if (!(other_m > 0) || std::abs(off_m) > same_m) continue;
        const auto weight = static_cast<float>((2 - dx * dx) * (2 - dy * dy));
        sum_m += weight * off_m;
        weights += weight;
      }
    }
    z_m = depth_m + sum_m / (weights * slope);
  }

  /// Fills one pixel without a return from two opposite ones, if they show one surface.
  void bridge(int x, int y, float& z_m, Eigen::Vector3f& plane_normal) const {
    static constexpr std::array<std::array<int, 2>, 4> kWays{{{1, 0}, {0, 1}, {1, 1}, {1, -1}}};
    for (const auto& [dx, dy] : kWays) {
      if (!has_return(x - dx, y - dy) || !has_return(x + dx, y + dy)) continue;
      const Eigen::Vector3f ray_a = rays_.at(x - dx, y - dy);
      const Eigen::Vector3f ray_b = rays_.at(x + dx, y + dy);
      const Eigen::Vector3f a = ray_a * depth_m_.at(x - dx, y - dy);
      const Eigen::Vector3f b = ray_b * depth_m_.at(x + dx, y + dy);
      const Eigen::Vector3f normal_a = normal_at(x - dx, y - dy, ray_a);
      const Eigen::Vector3f normal_b = normal_at(x + dx, y + dy, ray_b);
      if (std::abs(normal_a.dot(b - a)) > same_surface_m(a.z()) ||
          std::abs(normal_b.dot(a - b)) > same_surface_m(b.z()))
        continue;
      const Eigen::Vector3f normal = (normal_a + normal_b).normalized();
      const float slope = normal.dot(rays_.at(x, y));
      if (!(slope < -kMinSmoothedSlope)) continue;
      plane_normal = normal;
      z_m = 0.5f * normal.dot(a + b) / slope;
      return;
    }
  }

  [[nodiscard]] bool has_return(int x, int y) const { return depth_m_.contains(x, y) && depth_m_.at(x, y) > 0; }

 private:
  [[nodiscard]] Eigen::Vector3f normal_at(int x, int y, const Eigen::Vector3f& ray) const {
    const Eigen::Vector3f normal = normals_.empty() ? Eigen::Vector3f::Zero() : normals_.at(x, y);
    return normal.squaredNorm() > 0 ? normal : Eigen::Vector3f(-ray.normalized());
  }
  [[nodiscard]] float same_surface_m(float depth_m) const { return kSameSurfaceSigmas * noise_.sigma_m(depth_m); }

  const DepthImage& depth_m_;
  const Image<Eigen::Vector3f>& normals_;
  Rays rays_;
  FloatNoise noise_;
};

}  // namespace

SurfaceImage::SurfaceImage(const Frame& frame, const NoiseModel& noise)
    : z_m(Image<float>::uninitialised(frame.depth_m.width(), frame.depth_m.height())),
      normals(Image<Eigen::Vector3f>::uninitialised(frame.depth_m.width(), frame.depth_m.height())) {
  const Planes planes(frame, noise);
  const Rays rays(frame.intrinsics);
  const FloatNoise noise_in_float(noise);
  const int width = z_m.width();
  const int height = z_m.height();
  tbb::parallel_for(0, height, [&](int y) {
    std::ranges::fill(z_m.row(y), 0.0f);
    std::ranges::fill(normals.row(y), Eigen::Vector3f::Zero());
    const bool is_inner = y > 0 && y + 1 < height && width >= kPixelGroup + 2;
    if (is_inner) {
      const DepthRows rows{&frame.depth_m.at(0, y - 1), &frame.depth_m.at(0, y), &frame.depth_m.at(0, y + 1),
                           frame.normals.empty() ? nullptr : &frame.normals.at(0, y), width};
      smooth_row(rows, y, rays, noise_in_float, &z_m.at(0, y), &normals.at(0, y));
    }
    const auto depth_m = frame.depth_m.row(y);
    for (int x = 0; x < width; ++x) {
      const bool is_done = is_inner && x > 0 && x + 1 < width;
      if (!(depth_m[static_cast<std::size_t>(x)] > 0)) {
        planes.bridge(x, y, z_m.at(x, y), normals.at(x, y));
      } else if (!is_done) {
        planes.smooth(x, y, z_m.at(x, y), normals.at(x, y));
      }
    }
  });
}

}  // namespace scanknit
