#include "synth/noise.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "core/check.h"
#include "core/counter_random.h"

namespace scanknit {
namespace {

class NoisyCamera {
 public:
  NoisyCamera(const DepthImage& depth_m, const Image<float>& cos_incidence, const CameraIntrinsics& intrinsics,
              const KinectNoise& noise)
      : depth_m_(depth_m), cos_incidence_(cos_incidence), focal_px_(std::abs(intrinsics.fx)), noise_(noise) {}

  [[nodiscard]] float measure(int x, int y, CounterRandom random) const {
    // Every pixel draws the same count of numbers in the same order, even if it does not use them.
    const double edge_draw = random.uniform();
    const double flight = random.uniform();
    const double grazing_draw = random.uniform();
    const double gaussian = random.gaussian();

    double z = static_cast<double>(depth_m_.at(x, y));
    if (!(z > 0)) return 0;
    if (grazing_draw < grazing_probability(static_cast<double>(cos_incidence_.at(x, y)))) return 0;
    if (const double step = depth_step(x, y); step != 0) {
      if (edge_draw < noise_.edge_dropout) return 0;
      if (edge_draw < noise_.edge_dropout + noise_.flying_pixel) z += flight * step;
    }
    z = quantise(z + gaussian_sigma(z) * gaussian);
    return z >= noise_.min_depth_m && z <= noise_.max_depth_m ? static_cast<float>(z) : 0.0f;
  }

 private:
  /// The depth step of one disparity step: z = baseline * focal / disparity, so that dz = z^2 / (baseline * focal) d.
  [[nodiscard]] double step_m(double z) const {
    return z * z * noise_.disparity_step_px / (noise_.baseline_m * noise_.sensor_focal_px);
  }

  [[nodiscard]] double gaussian_sigma(double z) const {
    const double total = noise_.axial.sigma_m(z);
    const double step = step_m(z);
    return std::sqrt(std::max(0.0, total * total - step * step / 12));
  }

  [[nodiscard]] double quantise(double z) const {
    if (noise_.disparity_step_px == 0 || !(z > 0)) return z;
    const double factor = noise_.baseline_m * noise_.sensor_focal_px;
    const double disparity = std::round(factor / z / noise_.disparity_step_px) * noise_.disparity_step_px;
    return disparity > 0 ? factor / disparity : 0;
  }

  [[nodiscard]] double grazing_probability(double cosine) const {
    const double incidence = std::acos(std::clamp(cosine, 0.0, 1.0));
    const double width = noise_.grazing_end_rad - noise_.grazing_begin_rad;
    if (!(width > 0)) return incidence > noise_.grazing_end_rad ? 1 : 0;
    return std::clamp((incidence - noise_.grazing_begin_rad) / width, 0.0, 1.0);
  }

  /// The largest depth step to one of the eight neighbours; 0 if the surface is continuous. The slope of a slanted
  /// plane is not a step: up to three times z tan(incidence) / f is allowed.
  [[nodiscard]] double depth_step(int x, int y) const {
    constexpr double kSmallestStep_m = 0.015;
    const double z = static_cast<double>(depth_m_.at(x, y));
    const double cosine = std::max(0.05, static_cast<double>(cos_incidence_.at(x, y)));
    const double slope = std::sqrt(1 - std::min(1.0, cosine * cosine)) / cosine;
    const double allowed = std::max(kSmallestStep_m, 3 * z / focal_px_ * slope);
    double largest = 0;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if (!depth_m_.contains(x + dx, y + dy)) continue;
        const double other = static_cast<double>(depth_m_.at(x + dx, y + dy));
        // Beyond the rim of an object without background there is no second depth to mix with.
        const double step = other > 0 ? other - z : kSmallestStep_m;
        const bool is_step = !(other > 0) || std::abs(step) > allowed;
        if (is_step && std::abs(step) > std::abs(largest)) largest = step;
      }
    }
    return largest;
  }

  const DepthImage& depth_m_;
  const Image<float>& cos_incidence_;
  double focal_px_;
  const KinectNoise& noise_;
};

}  // namespace

DepthImage add_kinect_noise(const DepthImage& depth_m, const Image<float>& cos_incidence,
                            const CameraIntrinsics& intrinsics, const KinectNoise& noise, std::uint64_t seed,
                            std::uint64_t frame) {
  SCANKNIT_CHECK(cos_incidence.width() == depth_m.width() && cos_incidence.height() == depth_m.height());
  const NoisyCamera camera(depth_m, cos_incidence, intrinsics, noise);
  DepthImage noisy(depth_m.width(), depth_m.height());
  tbb::parallel_for(0, depth_m.height(), [&](int y) {
    for (int x = 0; x < depth_m.width(); ++x) {
      const auto pixel =
          static_cast<std::uint64_t>(y) * static_cast<std::uint64_t>(depth_m.width()) + static_cast<std::uint64_t>(x);
      noisy.at(x, y) = camera.measure(x, y, CounterRandom(seed, frame, pixel));
    }
  });
  return noisy;
}

}  // namespace scanknit
