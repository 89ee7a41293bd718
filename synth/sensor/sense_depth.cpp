#include "synth/sensor/sense_depth.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/check.h"
#include "core/counter_random.h"
#include "synth/sensor/correlated_noise.h"
#include "synth/sensor/depth_effects.h"

namespace scanknit {
namespace {

constexpr std::uint64_t kMatching = 1, kPatches = 2, kSideways = 3, kUpwards = 4, kPixel = 5;  // purposes of noise

/// The random numbers of one pixel, drawn in this order even if they are not used.
struct Draws {
  double dropout, flying, flight;
};

class DepthSensor {
 public:
  DepthSensor(const RenderedView& view, const CameraIntrinsics& camera, const RenderedSensor& sensor,
              const NoiseKey& noise)
      : view_(view), sensor_(sensor), noise_(noise), scale_(picture_scale(sensor, camera)), focal_px_(camera.fx) {
    depth_m_ = smear_corners(view.depth_m, focal_px_, sensor.corners.share, sensor.corners.radius_m);
    prepare_noise();
    prepare_edges();
    if (sensor.bias.share > 0) {
      bias_ = smooth_field(depth_m_.width(), depth_m_.height(), sensor.bias.cells, noise.seed);
    }
  }

  [[nodiscard]] float measure(int x, int y) const {
    const Draws draws = draw(x, y);
    if (!(depth_m_.at(x, y) > 0) || !returns(x, y)) return 0;
    if (is_in_shadow(x, y)) return 0;
    double z = seen_depth(x, y);
    if (!edge_.empty() && edge_.at(x, y) != 0) {
      if (draws.dropout < sensor_.edges.dropout) return 0;
      if (draws.flying < sensor_.edges.flying) z = flying_depth(x, y, z, draws.flight);
    }
    z = noisy(biased(z, x, y), matching_.empty() ? 0 : static_cast<double>(matching_.at(x, y)));
    return z >= sensor_.range.min_m && z <= sensor_.range.max_m ? static_cast<float>(z) : 0.0f;
  }

 private:
  [[nodiscard]] bool has_disparity() const { return sensor_.disparity.baseline_m > 0; }
  [[nodiscard]] double focal_times_baseline() const {
    return sensor_.disparity.focal_px * sensor_.disparity.baseline_m;
  }

  [[nodiscard]] Image<float> field(std::uint64_t purpose, double window_px) const {
    return correlated_noise(depth_m_.width(), depth_m_.height(), scale_ * window_px,
                            {noise_.seed, purpose, noise_.frame});
  }

  void prepare_noise() {
    const bool is_noisy = sensor_.disparity.noise_px > 0 || sensor_.ranging.floor_m > 0 || sensor_.ranging.share > 0;
    if (is_noisy) matching_ = field(kMatching, sensor_.disparity.window_px);
    const ReturnModel& returns = sensor_.returns;
    if (returns.patches > 0 || returns.grazing_begin_deg < 90) patches_ = field(kPatches, sensor_.disparity.window_px);
  }

  void prepare_edges() {
    const EdgeModel& edges = sensor_.edges;
    const ShadowModel& shadow = sensor_.shadow;
    if (shadow.right_m > 0) at_left_ = occlusion_shadows(depth_m_, focal_px_, shadow.right_m);
    if (shadow.left_m > 0) at_right_ = occlusion_shadows(depth_m_, focal_px_, -shadow.left_m);
    if (edges.dropout == 0 && edges.flying == 0 && edges.lateral_px == 0) return;
    constexpr double kSeenStep_px = 0.5;  // of disparity: less of a step does not disturb the matching
    const StepThreshold threshold{.per_square_metre = has_disparity() ? kSeenStep_px / focal_times_baseline() : 0};
    const auto reach = static_cast<int>(std::lround(scale_ * edges.reach_px)) - 1;  // a step marks both of its sides
    edge_ = widened(depth_steps(depth_m_, threshold), std::max(0, reach));
    if (!(edges.lateral_px > 0)) return;
    constexpr double kRagged_px = 3;
    sideways_ = field(kSideways, kRagged_px);
    upwards_ = field(kUpwards, kRagged_px);
  }

  [[nodiscard]] bool is_in_shadow(int x, int y) const {
    return (!at_left_.empty() && at_left_.at(x, y) != 0) || (!at_right_.empty() && at_right_.at(x, y) != 0);
  }

  [[nodiscard]] Draws draw(int x, int y) const {
    const auto pixel =
        static_cast<std::uint64_t>(y) * static_cast<std::uint64_t>(depth_m_.width()) + static_cast<std::uint64_t>(x);
    CounterRandom random(noise_.seed, mix64(kPixel + 1) + noise_.frame, pixel);
    const double dropout = random.uniform();
    const double flying = random.uniform();
    return {dropout, flying, random.uniform()};
  }

  /// Whether enough light comes back: it falls with the square of depth and with the cosine of incidence.
  [[nodiscard]] bool returns(int x, int y) const {
    const ReturnModel& model = sensor_.returns;
    const SurfaceMaterial& material = view_.material.at(x, y);
    const auto cosine = static_cast<double>(view_.cos_incidence.at(x, y));
    const double patch = patches_.empty() ? 0 : static_cast<double>(patches_.at(x, y));
    const double diffuse = static_cast<double>(material.reflectivity) *
                           (1 - model.gloss * static_cast<double>(material.gloss)) * std::exp(model.patches * patch);
    if (diffuse < model.dark || (model.dark > 0 && diffuse <= 0)) return false;
    const double reach = model.reach_m > 0 ? static_cast<double>(depth_m_.at(x, y)) / model.reach_m : 0;
    if (diffuse * cosine < reach * reach) return false;
    // A patch's place in the normal distribution is uniform in [0, 1]: holes of the window's size.
    const double place = 0.5 * std::erfc(-patch / std::numbers::sqrt2);
    return model.grazing_begin_deg >= 90 || place >= grazing_dropout(cosine);
  }

  [[nodiscard]] double grazing_dropout(double cosine) const {
    const ReturnModel& model = sensor_.returns;
    const double incidence_deg = std::acos(std::clamp(cosine, 0.0, 1.0)) * 180 / std::numbers::pi;
    const double width = model.grazing_end_deg - model.grazing_begin_deg;
    if (!(width > 0)) return incidence_deg > model.grazing_end_deg ? 1.1 : 0;
    const double share = (incidence_deg - model.grazing_begin_deg) / width;
    return share >= 1 ? 1.1 : std::max(0.0, share);  // above 1: certain
  }

  /// The depth that the pixel reports before noise: beside a step, that of a place a little off.
  [[nodiscard]] double seen_depth(int x, int y) const {
    const auto own = static_cast<double>(depth_m_.at(x, y));
    if (sideways_.empty() || edge_.at(x, y) == 0) return own;
    const double lateral_px = scale_ * sensor_.edges.lateral_px;
    const int sx = x + static_cast<int>(std::lround(lateral_px * static_cast<double>(sideways_.at(x, y))));
    const int sy = y + static_cast<int>(std::lround(lateral_px * static_cast<double>(upwards_.at(x, y))));
    if (!depth_m_.contains(sx, sy) || !(depth_m_.at(sx, sy) > 0)) return own;
    return static_cast<double>(depth_m_.at(sx, sy));
  }

  /// Between `z` and the depth beside it that differs most, evenly in inverse depth, as a window mixes both.
  [[nodiscard]] double flying_depth(int x, int y, double z, double flight) const {
    const int reach = std::max(1, static_cast<int>(std::lround(scale_ * sensor_.edges.reach_px)));
    double other = z;
    for (int dy = -reach; dy <= reach; dy += reach) {
      for (int dx = -reach; dx <= reach; dx += reach) {
        if (!depth_m_.contains(x + dx, y + dy) || !(depth_m_.at(x + dx, y + dy) > 0)) continue;
        const auto beside = static_cast<double>(depth_m_.at(x + dx, y + dy));
        if (std::abs(beside - z) > std::abs(other - z)) other = beside;
      }
    }
    return 1 / ((1 - flight) / z + flight / other);
  }

  [[nodiscard]] double biased(double z, int x, int y) const {
    constexpr double kStated_m = 4;
    if (bias_.empty()) return z;
    return z * (1 + sensor_.bias.share * z / kStated_m * static_cast<double>(bias_.at(x, y)));
  }

  [[nodiscard]] double noisy(double z, double noise) const {
    const DisparityModel& model = sensor_.disparity;
    z += std::hypot(sensor_.ranging.floor_m, sensor_.ranging.share * z) * noise;
    if (!has_disparity() || !(z > 0)) return z;
    if (model.noise_px == 0 && model.step_px == 0) return z;
    double disparity = focal_times_baseline() / z + model.noise_px * noise;
    if (model.step_px > 0) disparity = std::round(disparity / model.step_px) * model.step_px;
    return disparity > 0 ? focal_times_baseline() / disparity : 0;
  }

  const RenderedView& view_;
  const RenderedSensor& sensor_;
  NoiseKey noise_;
  double scale_;
  double focal_px_;
  DepthImage depth_m_;
  Image<std::uint8_t> at_left_, at_right_, edge_;  // empty where the effect is off, as below
  Image<float> matching_, patches_, sideways_, upwards_, bias_;
};

}  // namespace

DepthImage sense_depth(const RenderedView& view, const CameraIntrinsics& camera, const RenderedSensor& sensor,
                       std::uint64_t seed, std::uint64_t frame) {
  SCANKNIT_CHECK(view.depth_m.width() == camera.width && view.depth_m.height() == camera.height);
  const DepthSensor depth_sensor(view, camera, sensor, {seed, 0, frame});
  DepthImage sensed(camera.width, camera.height);
  tbb::parallel_for(0, camera.height, [&](int y) {
    for (int x = 0; x < camera.width; ++x) sensed.at(x, y) = depth_sensor.measure(x, y);
  });
  return sensed;
}

}  // namespace scanknit
