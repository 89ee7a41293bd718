// DepthCorrection: what it takes out of depth, and its bounds.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "acquire/sensor/depth_bias.h"

namespace scanknit {
namespace {

DepthBias even_bias(double scale, double shift_per_m) {
  return {5, 4, std::vector<double>(20, scale), std::vector<double>(20, shift_per_m)};
}

float corrected(const DepthBias& bias, float z_m) {
  DepthImage depth_m(19, 7, z_m);
  DepthCorrection(bias, 19, 7).apply(depth_m);
  return depth_m.at(18, 6);
}

TEST(DepthBias, EvenNumbersAreAScaleAndAShiftOfInverseDepth) {
  EXPECT_NEAR(1 / corrected(even_bias(0.01, 0.004), 2), 1.01 / 2 + 0.004, 1e-6);
}

TEST(DepthBias, NoReturnStaysNone) {
  EXPECT_EQ(corrected(even_bias(0.01, 0.004), 0), 0);
}

TEST(DepthBias, DepthKeepsItsOrderHoweverFar) {
  for (const double sign : {-1.0, 1.0}) {
    const DepthBias bias = even_bias(sign * DepthBias::kMostScale, sign * DepthBias::kMostShift_per_m);
    float last = 0;
    for (float z = 0.1F; z < 100; z *= 1.1F) {
      const float now = corrected(bias, z);
      EXPECT_GT(now, last) << z;
      EXPECT_TRUE(std::isfinite(now)) << z;
      last = now;
    }
  }
}

TEST(DepthBias, SplineWeightsAddUpAndGoOnSmoothlyAcrossCells) {
  for (const double position : {-1.0, 0.0, 0.3, 0.5, 1.0, 2.0}) {
    const SplineWeights at = spline_weights(position, 7);
    EXPECT_NEAR(at.weights[0] + at.weights[1] + at.weights[2] + at.weights[3], 1, 1e-12);
    EXPECT_GE(at.first, 0);
    EXPECT_LE(at.first, 3);
  }
  const SplineWeights before = spline_weights(0.25 - 1e-9, 7), after = spline_weights(0.25, 7);
  EXPECT_EQ(before.first + 1, after.first);
  EXPECT_NEAR(before.weights[1], after.weights[0], 1e-6);
}

TEST(DepthBias, RefusesNumbersThatAreNoneOrTooMany) {
  DepthBias bias = even_bias(0, 0);
  EXPECT_TRUE(is_valid(bias));
  bias.scale[3] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(is_valid(bias));
  EXPECT_FALSE(is_valid(even_bias(0.11, 0)));
  bias = even_bias(0, 0);
  bias.shift_per_m.pop_back();
  EXPECT_FALSE(is_valid(bias));
}

}  // namespace
}  // namespace scanknit
