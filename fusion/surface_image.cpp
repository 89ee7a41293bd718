#include "fusion/surface_image.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>

namespace scanknit {
namespace {

// Two pixels of one surface differ by sqrt(2) sigma; a neighbour that is off by three times that shows another surface.
constexpr float kSameSurfaceSigmas = 4.25f;

// Where a surface is seen at a more grazing angle its offset says little of its depth.
constexpr float kMinSlope = 0.1f;

/// Rays through pixel centres, z = 1.
struct Rays {
  float per_fx, per_fy, cx, cy;
  explicit Rays(const CameraIntrinsics& k)
      : per_fx(static_cast<float>(1 / k.fx)),
        per_fy(static_cast<float>(1 / k.fy)),
        cx(static_cast<float>(k.cx)),
        cy(static_cast<float>(k.cy)) {}
  [[nodiscard]] Eigen::Vector3f at(int x, int y) const {
    return {(static_cast<float>(x) - cx) * per_fx, (static_cast<float>(y) - cy) * per_fy, 1};
  }
};

class Planes {
 public:
  Planes(const Frame& frame, const NoiseModel& noise)
      : depth_m_(frame.depth_m), normals_(frame.normals), rays_(frame.intrinsics), noise_(noise) {}

  /// Fills one pixel that has a return.
  void smooth(int x, int y, float& z_m, PackedNormal& packed) const {
    const float depth_m = depth_m_.at(x, y);
    const Eigen::Vector3f ray = rays_.at(x, y);
    const Eigen::Vector3f normal = normal_at(x, y, ray);
    packed = pack(normal);
    const float slope = normal.dot(ray);  // negative: the normal points to the camera
    if (!(slope < -kMinSlope)) {
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
  void bridge(int x, int y, float& z_m, PackedNormal& packed) const {
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
      if (!(slope < -kMinSlope)) continue;
      packed = pack(normal);
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
  [[nodiscard]] float same_surface_m(float depth_m) const {
    return kSameSurfaceSigmas * static_cast<float>(noise_.sigma_m(static_cast<double>(depth_m)));
  }

  const DepthImage& depth_m_;
  const Image<Eigen::Vector3f>& normals_;
  Rays rays_;
  const NoiseModel& noise_;
};

}  // namespace

PackedNormal pack(const Eigen::Vector3f& normal) {
  const auto x = static_cast<std::int32_t>(std::lrint(std::clamp(normal.x(), -1.0f, 1.0f) / kNormalUnit));
  const auto y = static_cast<std::int32_t>(std::lrint(std::clamp(normal.y(), -1.0f, 1.0f) / kNormalUnit));
  const std::uint32_t y_and_sign = (static_cast<std::uint32_t>(y) & ~1u) | (normal.z() > 0 ? 1u : 0u);
  return (static_cast<std::uint32_t>(x) & 0xFFFFu) | (y_and_sign << 16);
}

Eigen::Vector3f unpack(PackedNormal packed) {
  const float x = static_cast<float>(static_cast<std::int16_t>(packed & 0xFFFFu)) * kNormalUnit;
  const float y = static_cast<float>(static_cast<std::int16_t>(packed >> 16)) * kNormalUnit;
  const float z = std::sqrt(std::max(0.0f, 1 - x * x - y * y));
  return {x, y, ((packed >> 16) & 1) != 0 ? z : -z};
}

SurfaceImage::SurfaceImage(const Frame& frame, const NoiseModel& noise)
    : z_m(frame.depth_m.width(), frame.depth_m.height()), normals(frame.depth_m.width(), frame.depth_m.height()) {
  const Planes planes(frame, noise);
  tbb::parallel_for(0, z_m.height(), [&](int y) {
    for (int x = 0; x < z_m.width(); ++x) {
      if (planes.has_return(x, y)) {
        planes.smooth(x, y, z_m.at(x, y), normals.at(x, y));
      } else {
        planes.bridge(x, y, z_m.at(x, y), normals.at(x, y));
      }
    }
  });
}

}  // namespace scanknit
