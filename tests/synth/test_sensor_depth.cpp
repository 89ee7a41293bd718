// Each effect of a depth sensor by itself, against the value that its key states.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <vector>

#include "synth/sensor/correlated_noise.h"
#include "synth/sensor/depth_effects.h"
#include "synth/sensor/sense_depth.h"
#include "synth/sensor/sensor_names.h"

namespace scanknit {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 240;
constexpr std::uint64_t kSeed = 20261125;
constexpr double kFocal_px = 262.5;
const CameraIntrinsics kCamera{kWidth, kHeight, kFocal_px, kFocal_px, 159.5, 119.5};

/// A wall square to the camera, made of one material.
RenderedView wall(float depth_m, const SurfaceMaterial& material = {}, float cos_incidence = 1) {
  return {DepthImage(kWidth, kHeight, depth_m), Image<float>(kWidth, kHeight, cos_incidence),
          ColourImage(kWidth, kHeight), Image<SurfaceMaterial>(kWidth, kHeight, material)};
}

/// The left half of the picture at one depth, the right half at another.
RenderedView two_walls(float left_m, float right_m) {
  RenderedView view = wall(left_m);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = kWidth / 2; x < kWidth; ++x) view.depth_m.at(x, y) = right_m;
  }
  return view;
}

/// A sensor of the picture's own size, with all effects off.
RenderedSensor nothing_but() {
  return {.width = kWidth, .height = kHeight, .picture_focal_px = kFocal_px};
}

DepthImage sensed(const RenderedView& view, const RenderedSensor& sensor, std::uint64_t seed = kSeed,
                  std::uint64_t frame = 0) {
  return sense_depth(view, kCamera, sensor, seed, frame);
}

double valid_share(const DepthImage& depth_m) {
  const auto valid = std::count_if(depth_m.pixels().begin(), depth_m.pixels().end(), [](float z) { return z > 0; });
  return static_cast<double>(valid) / static_cast<double>(depth_m.size());
}

/// Disparity noise without steps.
RenderedSensor matching(double noise_px, double window_px) {
  RenderedSensor sensor = nothing_but();
  sensor.disparity = {.baseline_m = 0.075, .focal_px = 580, .noise_px = noise_px, .window_px = window_px};
  return sensor;
}

/// The error of each pixel in disparity, in the sensor's pixels.
Image<double> disparity_error(const DepthImage& depth_m, double true_m, const DisparityModel& model) {
  Image<double> error(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const double factor = model.baseline_m * model.focal_px;
      error.at(x, y) = factor / static_cast<double>(depth_m.at(x, y)) - factor / true_m;
    }
  }
  return error;
}

/// The mean product of the errors of pixels `lag` apart in a row.
double covariance(const Image<double>& error, int lag) {
  double sum = 0;
  double count = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x + lag < kWidth; ++x) {
      sum += error.at(x, y) * error.at(x + lag, y);
      ++count;
    }
  }
  return sum / count;
}

TEST(IdealSensor, ReturnsTheExactDepthBitByBit) {
  const RenderedView view = two_walls(0.7f, 9.3f);
  EXPECT_EQ(sensed(view, nothing_but()), view.depth_m);
}

class DisparityNoise : public ::testing::TestWithParam<float> {};
INSTANTIATE_TEST_SUITE_P(Metres, DisparityNoise, ::testing::Values(0.6f, 1.5f, 3.0f));

TEST_P(DisparityNoise, HasTheStatedDeviationAtAnyDistance) {
  const RenderedSensor sensor = matching(0.1, 1);
  const DepthImage depth_m = sensed(wall(GetParam()), sensor);
  const Image<double> error = disparity_error(depth_m, static_cast<double>(GetParam()), sensor.disparity);
  EXPECT_NEAR(std::sqrt(covariance(error, 0)), 0.1, 0.002);  // 76,800 independent draws: deviation 0.0003
}

TEST(DisparityNoise, IsCorrelatedOverTheMatchingWindow) {
  constexpr double kWindow_px = 9;
  const RenderedSensor sensor = matching(0.1, kWindow_px);
  const Image<double> error = disparity_error(sensed(wall(1.0f), sensor), 1.0, sensor.disparity);
  const double variance = covariance(error, 0);
  EXPECT_NEAR(std::sqrt(variance), 0.1, 0.005);  // about 76,800 / 81 independent windows
  for (const int lag : {1, 3, 6}) EXPECT_NEAR(covariance(error, lag) / variance, 1 - lag / kWindow_px, 0.08) << lag;
  for (const int lag : {9, 12, 20}) EXPECT_NEAR(covariance(error, lag) / variance, 0, 0.12) << lag;
}

TEST(DisparityNoise, IsTheSameInMetresWhenThePictureIsRenderedSmaller) {
  RenderedSensor sensor = matching(0.1, 9);
  sensor.width = 2 * kWidth;  // the picture has half of the sensor's own width: a window of 4.5, made 5
  const Image<double> error = disparity_error(sensed(wall(1.0f), sensor), 1.0, sensor.disparity);
  EXPECT_NEAR(std::sqrt(covariance(error, 0)), 0.1, 0.005);
  EXPECT_NEAR(covariance(error, 5) / covariance(error, 0), 0, 0.1);
}

class DisparitySteps : public ::testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Pixels, DisparitySteps, ::testing::Values(1.0 / 8, 1.0 / 32));

TEST_P(DisparitySteps, AreTheOnlyDisparitiesThatAreReported) {
  RenderedSensor sensor = matching(0.3, 1);
  sensor.disparity.step_px = GetParam();
  const DepthImage depth_m = sensed(wall(2.0f), sensor);
  std::set<long> steps;
  for (const float z : depth_m.pixels()) {
    const double step = 0.075 * 580 / static_cast<double>(z) / GetParam();
    EXPECT_NEAR(step, std::round(step), 1e-3);
    steps.insert(std::lround(step));
  }
  const long middle = std::lround(0.075 * 580 / 2 / GetParam());
  for (long step = middle - 2; step <= middle + 2; ++step) EXPECT_TRUE(steps.contains(step)) << "none is left out";
}

TEST(RangingNoise, GrowsFromItsFloorWithDepth) {
  RenderedSensor sensor = nothing_but();
  sensor.ranging = {.floor_m = 0.004, .share = 0.01};
  for (const float depth : {0.5f, 2.0f, 4.0f}) {
    const DepthImage depth_m = sensed(wall(depth), sensor);
    double squares = 0;
    for (const float z : depth_m.pixels()) squares += std::pow(static_cast<double>(z - depth), 2);
    const double expected = std::hypot(0.004, 0.01 * static_cast<double>(depth));
    EXPECT_NEAR(std::sqrt(squares / static_cast<double>(depth_m.size())), expected, 0.02 * expected);
  }
}

TEST(Range, EndsAtItsLimits) {
  RenderedSensor sensor = nothing_but();
  sensor.range = {.min_m = 0.5, .max_m = 4};
  EXPECT_EQ(valid_share(sensed(wall(0.49f), sensor)), 0);
  EXPECT_EQ(valid_share(sensed(wall(0.51f), sensor)), 1);
  EXPECT_EQ(valid_share(sensed(wall(3.99f), sensor)), 1);
  EXPECT_EQ(valid_share(sensed(wall(4.01f), sensor)), 0);
}

TEST(Shadow, IsAsWideAsTheGeometrySaysAndLiesAtTheObjectsLeft) {
  RenderedSensor sensor = nothing_but();
  sensor.shadow.right_m = 0.075;
  const DepthImage depth_m = sensed(two_walls(3.0f, 1.0f), sensor);
  const double expected_px = kFocal_px * 0.075 * (1 / 1.0 - 1 / 3.0);  // 13.1
  for (const int y : {0, kHeight / 2, kHeight - 1}) {
    const auto row = depth_m.row(y);
    const auto holes = std::count(row.begin(), row.end(), 0.0f);
    EXPECT_NEAR(static_cast<double>(holes), expected_px, 1) << y;
    for (int x = kWidth / 2 - static_cast<int>(holes); x < kWidth / 2; ++x) EXPECT_EQ(depth_m.at(x, y), 0) << x;
  }
  EXPECT_EQ(valid_share(sensed(two_walls(1.0f, 3.0f), sensor)), 1) << "the other side of an object has none";
}

TEST(Shadow, OfTheMeasuringCameraLiesAtTheObjectsRight) {
  RenderedSensor sensor = nothing_but();
  sensor.shadow.left_m = 0.05;
  const DepthImage depth_m = sensed(two_walls(1.0f, 3.0f), sensor);
  const auto row = depth_m.row(kHeight / 2);
  const auto holes = std::count(row.begin(), row.end(), 0.0f);
  EXPECT_NEAR(static_cast<double>(holes), kFocal_px * 0.05 * (1 / 1.0 - 1 / 3.0), 1);
  for (int x = kWidth / 2; x < kWidth / 2 + static_cast<int>(holes); ++x) EXPECT_EQ(depth_m.at(x, 120), 0) << x;
  EXPECT_EQ(valid_share(sensed(two_walls(3.0f, 1.0f), sensor)), 1);
}

TEST(Shadow, IsNotThereOnASlantedPlane) {
  RenderedView view = wall(1.0f);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) view.depth_m.at(x, y) = static_cast<float>(1 / (0.5 + 0.002 * x));
  }
  RenderedSensor sensor = nothing_but();
  sensor.shadow.right_m = 0.075;
  EXPECT_EQ(valid_share(sensed(view, sensor)), 1);
}

TEST(Edges, LoseAndMixDepthBesideAStepOnly) {
  RenderedSensor sensor = nothing_but();
  sensor.edges = {.reach_px = 1, .dropout = 0.4, .flying = 0.5};
  const DepthImage depth_m = sensed(two_walls(1.0f, 2.0f), sensor);
  double dropped = 0;
  double flying = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const float z = depth_m.at(x, y);
      if (x != kWidth / 2 - 1 && x != kWidth / 2) {
        ASSERT_EQ(z, x < kWidth / 2 ? 1.0f : 2.0f) << x;
        continue;
      }
      dropped += z == 0 ? 1 : 0;
      flying += z > 1 && z < 2 ? 1 : 0;
    }
  }
  // Four deviations of the binomial; flying pixels are drawn among those that are not dropped.
  EXPECT_NEAR(dropped / (2 * kHeight), 0.4, 4 * std::sqrt(0.24 / (2 * kHeight)));
  EXPECT_NEAR(flying / (2 * kHeight), 0.6 * 0.5, 4 * std::sqrt(0.21 / (2 * kHeight)));
}

TEST(Edges, AreRaggedByTheLateralDeviation) {
  RenderedSensor sensor = nothing_but();
  sensor.edges = {.reach_px = 4, .lateral_px = 1};
  const DepthImage depth_m = sensed(two_walls(1.0f, 2.0f), sensor);
  // The last pixel before the edge, which is 0.5 px away, comes from beyond it when the shift rounds to 1 or more.
  double beyond = 0;
  for (int y = 0; y < kHeight; ++y) beyond += depth_m.at(kWidth / 2 - 1, y) == 2.0f ? 1 : 0;
  EXPECT_NEAR(beyond / kHeight, 0.31, 0.15);  // of a normal deviate above 0.5; the shifts are correlated over 3 rows
}

TEST(Returns, EndWhereLightFallsWithTheSquareOfDepth) {
  RenderedSensor sensor = nothing_but();
  sensor.returns.reach_m = 10;
  // sqrt(0.25) of the reach.
  EXPECT_EQ(valid_share(sensed(wall(4.9f, {.reflectivity = 0.25f}), sensor)), 1);
  EXPECT_EQ(valid_share(sensed(wall(5.1f, {.reflectivity = 0.25f}), sensor)), 0);
}

TEST(Returns, LackOnDarkAndOnGlossySurfaces) {
  RenderedSensor sensor = nothing_but();
  sensor.returns = {.dark = 0.05, .gloss = 1};
  EXPECT_EQ(valid_share(sensed(wall(1.0f, {.reflectivity = 0.04f}), sensor)), 0);
  EXPECT_EQ(valid_share(sensed(wall(1.0f, {.reflectivity = 0.06f}), sensor)), 1);
  EXPECT_EQ(valid_share(sensed(wall(1.0f, {.reflectivity = 0.5f, .gloss = 0.95f}), sensor)), 0);
  EXPECT_EQ(valid_share(sensed(wall(1.0f, {.reflectivity = 0.5f, .gloss = 0.5f}), sensor)), 1);
}

TEST(Returns, FadeInPatchesAtTheirLimit) {
  RenderedSensor sensor = nothing_but();
  sensor.returns = {.dark = 0.1, .patches = 0.3};
  EXPECT_NEAR(valid_share(sensed(wall(1.0f, {.reflectivity = 0.1f}), sensor)), 0.5, 0.05);
}

TEST(Returns, FadeAtGrazingIncidence) {
  RenderedSensor sensor = nothing_but();
  sensor.returns.grazing_begin_deg = 70;
  sensor.returns.grazing_end_deg = 80;
  const auto share_at = [&](double degrees) {
    return valid_share(sensed(wall(1.0f, {}, static_cast<float>(std::cos(degrees * std::numbers::pi / 180))), sensor));
  };
  EXPECT_EQ(share_at(69), 1);
  EXPECT_NEAR(share_at(75), 0.5, 0.02);
  EXPECT_EQ(share_at(81), 0);
}

TEST(Corners, AreSmearedTowardsTheCameraAndPlanesAreNot) {
  // Two walls at 45 degrees that meet at 2 m, straight ahead.
  DepthImage depth_m(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      depth_m.at(x, y) = static_cast<float>(2 / (1 + std::abs(x - 159.5) / kFocal_px));
    }
  }
  constexpr double kRadius_m = 0.05;
  const DepthImage smeared = smear_corners(depth_m, kFocal_px, 0.4, kRadius_m);
  const auto at_corner = static_cast<double>(depth_m.at(159, 120));
  // The line between the points 6.6 px to both sides is 0.05 m nearer; 40 % of that.
  EXPECT_NEAR(at_corner - static_cast<double>(smeared.at(159, 120)), 0.4 * 0.05, 0.004);
  for (const int x : {120, 145, 175, 200}) EXPECT_NEAR(smeared.at(x, 120), depth_m.at(x, 120), 1e-6f) << x;
}

TEST(Bias, GrowsWithDistanceAndStaysBelowItsShare) {
  RenderedSensor sensor = nothing_but();
  sensor.bias = {.share = 0.02, .cells = 4};
  const DepthImage near = sensed(wall(2.0f), sensor);
  const DepthImage far = sensed(wall(4.0f), sensor);
  double largest = 0;
  for (std::size_t i = 0; i < far.size(); ++i) {
    const double error = static_cast<double>(far.pixels()[i]) / 4 - 1;
    largest = std::max(largest, std::abs(error));
    EXPECT_NEAR(static_cast<double>(near.pixels()[i]) / 2 - 1, error / 2, 1e-6);
  }
  EXPECT_LE(largest, 0.02);
  EXPECT_GT(largest, 0.01);
}

TEST(Bias, BelongsToTheUnitAndIsSmooth) {
  RenderedSensor sensor = nothing_but();
  sensor.bias = {.share = 0.02, .cells = 4};
  const DepthImage first = sensed(wall(4.0f), sensor);
  EXPECT_EQ(first, sensed(wall(4.0f), sensor, kSeed, 7)) << "the same in every picture";
  EXPECT_NE(first, sensed(wall(4.0f), sensor, kSeed + 1)) << "another unit has another bias";
  for (int x = 1; x < kWidth; ++x) EXPECT_NEAR(first.at(x, 100), first.at(x - 1, 100), 0.006f) << x;
}

class EverySensor : public ::testing::TestWithParam<std::string_view> {};
INSTANTIATE_TEST_SUITE_P(Named, EverySensor, ::testing::ValuesIn(kSensorNames),
                         [](const auto& name) { return std::string(name.param); });

TEST_P(EverySensor, GivesTheSameBitsForAnyNumberOfThreads) {
  const auto with_threads = [](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return sensed(two_walls(1.0f, 2.5f), *make_sensor(GetParam()));
  };
  EXPECT_EQ(with_threads(1), with_threads(8));
}

TEST_P(EverySensor, RepeatsForASeedAndAFrame) {
  const RenderedSensor sensor = *make_sensor(GetParam());
  const RenderedView view = two_walls(1.0f, 2.5f);
  EXPECT_EQ(sensed(view, sensor), sensed(view, sensor));
  if (GetParam() != "ideal") {
    EXPECT_NE(sensed(view, sensor), sensed(view, sensor, kSeed, 1));
    EXPECT_NE(sensed(view, sensor), sensed(view, sensor, kSeed + 1));
  }
}

TEST_P(EverySensor, SeesMostOfAWhiteWallAtOneAndAHalfMetres) {
  EXPECT_GT(valid_share(sensed(wall(1.5f, {.reflectivity = 0.8f}), *make_sensor(GetParam()))), 0.99);
}

TEST(CorrelatedNoise, HasUnitDeviationForAnyWindow) {
  for (const double window : {1.0, 3.0, 9.0}) {
    const Image<float> noise = correlated_noise(kWidth, kHeight, window, {kSeed, 1, 0});
    double squares = 0;
    for (const float value : noise.pixels()) squares += static_cast<double>(value) * static_cast<double>(value);
    EXPECT_NEAR(squares / static_cast<double>(noise.size()), 1, 0.02 * window) << window;
  }
}

}  // namespace
}  // namespace scanknit
