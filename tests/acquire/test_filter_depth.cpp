// Depth filters against analytic scenes.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "acquire/filter/depth_filter.h"
#include "test_filter_scenes.h"

namespace scanknit::test {
namespace {

TEST(RangeClip, KeepsTheEndsAndDropsBeyond) {
  DepthImage depth_m(4, 1);
  depth_m.at(0, 0) = 0.4F;
  depth_m.at(1, 0) = 0.5F;
  depth_m.at(2, 0) = 3.0F;
  depth_m.at(3, 0) = 3.1F;
  const DepthImage clipped = clip_range(depth_m, 0.5, 3.0);
  EXPECT_EQ(clipped.at(0, 0), 0.0F);
  EXPECT_EQ(clipped.at(1, 0), 0.5F);
  EXPECT_EQ(clipped.at(2, 0), 3.0F);
  EXPECT_EQ(clipped.at(3, 0), 0.0F);
}

TEST(RangeClip, WithoutUpperLimitKeepsTheFar) {
  const DepthImage depth_m(2, 2, 50.0F);
  EXPECT_EQ(clip_range(depth_m, 0.1, 0.0), depth_m);
}

TEST(DiscontinuityMask, KeepsAPlaneAtEighthyDegrees) {
  const DepthImage depth_m = render_plane(tilted(80 * kDegree), kCamera);
  EXPECT_EQ(mask_discontinuities(depth_m, {}, 3.0), depth_m);
}

TEST(DiscontinuityMask, KeepsAPlaneBehindAHoleLattice) {
  const DepthImage depth_m = with_lattice(render_plane(tilted(60 * kDegree), kCamera));
  EXPECT_EQ(mask_discontinuities(depth_m, {}, 3.0), depth_m);
}

TEST(DiscontinuityMask, KeepsAlmostEveryPixelOfANoisyPlane) {
  constexpr double kLostAtThreeSigma = 0.02;  // two tests a pixel, 0.27 % each, and half as much again for neighbours
  const DepthImage depth_m = with_noise(render_plane(tilted(30 * kDegree), kCamera), {});
  const DepthImage masked = mask_discontinuities(depth_m, {}, 3.0);
  EXPECT_LT(valid_pixels(depth_m) - valid_pixels(masked), kLostAtThreeSigma * valid_pixels(depth_m));
}

TEST(DiscontinuityMask, DropsBothRimsOfAStepAndNothingElse) {
  DepthImage depth_m(40, 10, 1.0F);
  for (int y = 0; y < 10; ++y) {
    for (int x = 20; x < 40; ++x) depth_m.at(x, y) = 1.2F;
  }
  const DepthImage masked = mask_discontinuities(depth_m, {}, 3.0);
  for (int x = 0; x < 40; ++x) EXPECT_EQ(masked.at(x, 5) == 0.0F, x == 19 || x == 20) << x;
}

TEST(DiscontinuityMask, DropsAFlyingPixelBetweenTwoSurfaces) {
  DepthImage depth_m(41, 10, 1.0F);
  for (int y = 0; y < 10; ++y) {
    depth_m.at(20, y) = 1.15F;
    for (int x = 21; x < 41; ++x) depth_m.at(x, y) = 1.6F;
  }
  EXPECT_EQ(mask_discontinuities(depth_m, {}, 3.0).at(20, 5), 0.0F);
}

TEST(DiscontinuityMask, DropsARimBesideAHole) {
  // Before the step two pixels are missing: the far rim has neighbours on one side only, and the spike leaves them.
  DepthImage depth_m(20, 1, 1.0F);
  depth_m.at(9, 0) = depth_m.at(10, 0) = depth_m.at(11, 0) = 0.0F;
  depth_m.at(12, 0) = 1.1F;
  EXPECT_EQ(mask_discontinuities(depth_m, {}, 3.0).at(12, 0), 0.0F);
  EXPECT_EQ(mask_discontinuities(depth_m, {}, 3.0).at(8, 0), 1.0F);
}

TEST(DiscontinuityMask, AtZeroSigmasIsOff) {
  DepthImage depth_m(3, 1, 1.0F);
  depth_m.at(1, 0) = 9.0F;
  EXPECT_EQ(mask_discontinuities(depth_m, {}, 0.0), depth_m);
}

TEST(BilateralFilter, HalvesNoiseOnAPlane) {
  const DepthImage truth = render_plane(tilted(20 * kDegree), kCamera);
  const DepthImage noisy = with_noise(truth, {});
  EXPECT_LT(rms_difference_m(smooth_bilateral(noisy, {}), truth), 0.5 * rms_difference_m(noisy, truth));
}

TEST(BilateralFilter, LeavesAStepSharp) {
  DepthImage depth_m(20, 20, 1.0F);
  for (int y = 0; y < 20; ++y) {
    for (int x = 10; x < 20; ++x) depth_m.at(x, y) = 1.1F;
  }
  constexpr float kLeak_m = 1e-5F;  // 0.1 m is 40 range sigmas
  const DepthImage smooth = smooth_bilateral(depth_m, {});
  EXPECT_NEAR(smooth.at(9, 10), 1.0F, kLeak_m);
  EXPECT_NEAR(smooth.at(10, 10), 1.1F, kLeak_m);
}

TEST(BilateralFilter, FillsNoHoles) {
  const DepthImage depth_m = with_lattice(DepthImage(20, 20, 1.0F));
  const DepthImage smooth = smooth_bilateral(depth_m, {});
  for (std::size_t i = 0; i < depth_m.size(); ++i) EXPECT_EQ(smooth.pixels()[i] > 0, depth_m.pixels()[i] > 0);
}

TEST(FilterFrame, AppliesWhatTheConfigurationAsksFor) {
  Frame frame;
  frame.intrinsics = kCamera;
  frame.depth_m = render_plane(tilted(0), kCamera);
  frame.depth_m.at(5, 5) = 4.0F;
  AcquireConfig config;
  config.max_depth_m = 2.0;
  config.bilateral = true;
  config.outlier_neighbours = 8;
  config.outlier_sigmas = 100;
  ASSERT_TRUE(filter_frame(frame, config, {}));
  EXPECT_EQ(frame.depth_m.at(5, 5), 0.0F);
  EXPECT_EQ(frame.normals.width(), kCamera.width);
  EXPECT_NEAR(frame.normals.at(80, 60).z(), -1.0F, 1e-4F);
}

}  // namespace
}  // namespace scanknit::test
