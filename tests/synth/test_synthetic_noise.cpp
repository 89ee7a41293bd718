#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <set>

#include "synth/noise.h"

namespace scanknit {
namespace {

constexpr int kWidth = 200;
constexpr int kHeight = 150;
constexpr std::uint64_t kSeed = 20260101;
const CameraIntrinsics kCamera{kWidth, kHeight, 525, 525, 99.5, 74.5};

/// A wall square to the camera.
DepthImage wall(float depth_m) {
  return {kWidth, kHeight, depth_m};
}
const Image<float> kHeadOn(kWidth, kHeight, 1.0f);

DepthImage noisy(const DepthImage& depth_m, const KinectNoise& noise = {}, std::uint64_t seed = kSeed,
                 std::uint64_t frame = 0) {
  return add_kinect_noise(depth_m, kHeadOn, kCamera, noise, seed, frame);
}

struct Moments {
  double mean = 0;
  double deviation = 0;
};
Moments moments(const DepthImage& depth_m) {
  double sum = 0;
  double squares = 0;
  for (const float z : depth_m.pixels()) {
    sum += static_cast<double>(z);
    squares += static_cast<double>(z) * static_cast<double>(z);
  }
  const auto n = static_cast<double>(depth_m.size());
  return {sum / n, std::sqrt(std::max(0.0, squares / n - sum / n * sum / n))};
}

class NoiseAtDepth : public ::testing::TestWithParam<float> {};
INSTANTIATE_TEST_SUITE_P(Metres, NoiseAtDepth, ::testing::Values(0.6f, 1.0f, 2.0f, 3.0f, 4.0f));

TEST_P(NoiseAtDepth, HasTheModelsDeviationWithinFivePercent) {
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  const double expected = NoiseModel{}.sigma_m(static_cast<double>(GetParam()));
  EXPECT_NEAR(moments(noisy(wall(GetParam()))).deviation, expected, 0.05 * expected);
}

TEST_P(NoiseAtDepth, HasTheModelsDeviationWithoutQuantisationToo) {
  KinectNoise noise;
  noise.disparity_step_px = 0;
  const double expected = NoiseModel{}.sigma_m(static_cast<double>(GetParam()));
  EXPECT_NEAR(moments(noisy(wall(GetParam()), noise)).deviation, expected, 0.05 * expected);
}

TEST_P(NoiseAtDepth, HasTheTrueDepthAsItsMean) {
  const auto z = static_cast<double>(GetParam());
  const double sigma = NoiseModel{}.sigma_m(z);
  // Four deviations of the mean, and the bias sigma^2 / z that rounding in disparity (1 / z) may bring.
  EXPECT_NEAR(moments(noisy(wall(GetParam()))).mean, z, 4 * sigma / std::sqrt(kWidth * kHeight) + sigma * sigma / z);
}

TEST(KinectNoise, QuantisesInStepsOf26MillimetresAtThreeMetres) {
  const DepthImage depth_m = noisy(wall(3.0f));
  const std::set<float> levels(depth_m.pixels().begin(), depth_m.pixels().end());
  const auto above = levels.upper_bound(3.0f);
  ASSERT_NE(above, levels.begin());
  ASSERT_NE(above, levels.end());
  EXPECT_NEAR(*above - *std::prev(above), 0.026, 0.001);
}

TEST(KinectNoise, RepeatsForASeedAndFrameAndDiffersForOthers) {
  const DepthImage first = noisy(wall(1.0f));
  EXPECT_EQ(first, noisy(wall(1.0f)));
  EXPECT_NE(first, noisy(wall(1.0f), {}, kSeed + 1));
  EXPECT_NE(first, noisy(wall(1.0f), {}, kSeed, 1));
}

TEST(KinectNoise, GivesTheSameBitsForAnyNumberOfThreads) {
  const auto with_threads = [](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return noisy(wall(2.0f));
  };
  EXPECT_EQ(with_threads(1), with_threads(8));
}

TEST(KinectNoise, DropsPixelsBesideADepthStepOnly) {
  DepthImage steps(kWidth, kHeight, 1.0f);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = kWidth / 2; x < kWidth; ++x) steps.at(x, y) = 2.0f;
  }
  const DepthImage depth_m = noisy(steps);
  int dropped = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      if (x == kWidth / 2 || x == kWidth / 2 - 1) {
        dropped += depth_m.at(x, y) == 0 ? 1 : 0;
      } else {
        EXPECT_GT(depth_m.at(x, y), 0) << x;
      }
    }
  }
  // Four deviations of the binomial.
  EXPECT_NEAR(dropped / (2.0 * kHeight), 0.5, 4 * std::sqrt(0.25 / (2.0 * kHeight)));
}

TEST(KinectNoise, SeesNothingAtGrazingIncidence) {
  const auto share_at = [](double degrees) {
    const Image<float> slanted(kWidth, kHeight, static_cast<float>(std::cos(degrees * 3.14159265358979 / 180)));
    const DepthImage depth_m = add_kinect_noise(wall(1.0f), slanted, kCamera, {}, kSeed, 0);
    double returned = 0;
    for (const float z : depth_m.pixels()) returned += z > 0 ? 1 : 0;
    return returned / static_cast<double>(depth_m.size());
  };
  EXPECT_EQ(share_at(70), 1);
  EXPECT_NEAR(share_at(80), 0.5, 0.02);
  EXPECT_EQ(share_at(86), 0);
}

TEST(KinectNoise, ReturnsNothingOutsideItsRange) {
  for (const float depth : {0.0f, 0.3f, 5.5f, 40.0f}) {
    const DepthImage seen = noisy(wall(depth));
    for (const float z : seen.pixels()) ASSERT_EQ(z, 0) << depth;
  }
}

}  // namespace
}  // namespace scanknit
