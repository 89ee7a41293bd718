// Colours for texels, from frames.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "export/texture/srgb.h"
#include "export/texture/texel_size.h"
#include "export/texture/texture_baker.h"
#include "export/texture/texture_fill.h"
#include "tests/export/texture_samples.h"

namespace scanknit {
namespace {

constexpr Rgb8 kRed{200, 40, 30}, kGrey{128, 128, 128};

Rgb8 plain_red(double, double) {
  return kRed;
}

/// Squares of 5 cm.
Rgb8 checks(double x_m, double y_m) {
  const int parity = static_cast<int>(std::floor(x_m / 0.05)) + static_cast<int>(std::floor(y_m / 0.05));
  return (parity & 1) != 0 ? Rgb8{30, 60, 160} : Rgb8{180, 170, 60};
}

class Bake : public ::testing::Test {
 protected:
  [[nodiscard]] BakedTexture baked(const std::vector<Frame>& frames) const {
    TextureBaker baker(mesh_, atlas_, {0.01, 3, NoiseModel{0.001, 0, 0}});
    for (const Frame& frame : frames) baker.add(frame, Pose::Identity());
    return baker.bake();
  }

  /// Calls `look(p, colour)` for each texel.
  template <typename Look>
  void for_each(const BakedTexture& texture, Look&& look) const {
    for (std::size_t t = 0; t < atlas_.triangles.size(); ++t) {
      for_each_texel(atlas_.corners(t), [&](int x, int y, const std::array<float, 3>& w) {
        Eigen::Vector3f p = Eigen::Vector3f::Zero();
        for (std::size_t k = 0; k < 3; ++k) p += w[k] * mesh_.positions_m[atlas_.source[atlas_.triangles[t][k]]];
        look(p, texture.image.at(x, y));
        return true;
      });
    }
  }

  Mesh mesh_ = test::wall();
  TextureAtlas atlas_ = test::atlas_of(mesh_, 0.0015);
};

int difference(Rgb8 a, Rgb8 b) {
  return std::max({std::abs(a.r - b.r), std::abs(a.g - b.g), std::abs(a.b - b.b)});
}

TEST_F(Bake, ShowsThePatternThatTheFrameShows) {
  mesh_.colours.clear();  // so that exposure is left alone
  const BakedTexture texture = baked({test::frame_of_wall(checks)});
  EXPECT_EQ(texture.frames, 1u);
  EXPECT_DOUBLE_EQ(texture.seen_share, 1);
  std::size_t looked = 0;
  for_each(texture, [&](const Eigen::Vector3f& p, Rgb8 colour) {
    const auto off_edge = [](float x_m) { return std::abs(std::remainder(x_m, 0.05f)) > 0.004f; };  // two pixels
    if (!off_edge(p.x()) || !off_edge(p.y())) return;
    EXPECT_LE(difference(colour, checks(p.x(), p.y())), 1);
    ++looked;
  });
  EXPECT_GT(looked, texture.texels / 2);
}

TEST_F(Bake, WhatNoFrameSawHasTheColourOfTheMesh) {
  Frame frame = test::frame_of_wall(plain_red);
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 160; ++x) frame.depth_m.at(x, y) = 0;  // the half with negative x
  }
  const BakedTexture texture = baked({frame});
  EXPECT_NEAR(texture.seen_share, 0.5, 0.03);
  for_each(texture, [&](const Eigen::Vector3f& p, Rgb8 colour) {
    if (p.x() < -0.01f) {
      EXPECT_EQ(colour, kGrey);
    }
  });
}

TEST_F(Bake, WhatStandsInTheWayIsNotPaintedOnTheWall) {
  Frame hidden = test::frame_of_wall(plain_red);
  for (float& depth : hidden.depth_m.pixels()) depth = 0.9f;
  EXPECT_EQ(baked({hidden}).seen_share, 0);
  Frame behind = test::frame_of_wall(plain_red);
  for (float& depth : behind.depth_m.pixels()) depth = 1.1f;
  EXPECT_EQ(baked({behind}).seen_share, 0);
}

TEST_F(Bake, AColourCameraBesideTheDepthCameraSeesRoundNothing) {
  // A post at half the way hides, from the colour camera 5 cm to its left, a stripe of the wall that depth sees.
  Frame frame = test::frame_of_wall(checks);
  for (int y = 0; y < 240; ++y) {
    for (int x = 150; x < 170; ++x) frame.depth_m.at(x, y) = 0.5f;
  }
  frame.colour->T_colour_depth.translation() = Eigen::Vector3d(0.05, 0, 0);
  for (Rgb8& pixel : frame.colour->image.pixels()) pixel = kRed;
  TextureBaker baker(mesh_, atlas_, {0.01, 3, NoiseModel{0.001, 0, 0}});
  baker.add(frame, Pose::Identity());
  const BakedTexture texture = baker.bake();
  // The post is 1 cm to either side of the axis at 0.5 m: seen from -5 cm it lies before 0.03 to 0.07 m of the wall.
  std::size_t hidden = 0, seen = 0;
  for_each(texture, [&](const Eigen::Vector3f& p, Rgb8 colour) {
    if (p.x() > 0.034f && p.x() < 0.066f) {
      EXPECT_EQ(colour, kGrey) << p.transpose();
      ++hidden;
    }
    if (p.x() < -0.04f && p.x() > -0.15f && std::abs(p.y()) < 0.15f && colour != kGrey) ++seen;
  });
  EXPECT_GT(hidden, 1000u);
  EXPECT_GT(seen, 10'000u);
}

TEST_F(Bake, FramesOfAnotherExposureAreBroughtToThatOfTheMesh) {
  const auto dimmed = [](double share) {
    return [share](double, double) {
      const std::uint8_t value = srgb_from_linear(share * linear_from_srgb(kGrey.r));
      return Rgb8{value, value, value};
    };
  };
  mesh_ = test::wall(32);  // enough vertices to compare
  atlas_ = test::atlas_of(mesh_, 0.0015);
  const BakedTexture texture = baked({test::frame_of_wall(dimmed(0.7)), test::frame_of_wall(dimmed(1.6))});
  for_each(texture, [&](const Eigen::Vector3f&, Rgb8 colour) { EXPECT_LE(difference(colour, kGrey), 1); });
}

TEST_F(Bake, TheNearerFrameIsBelieved) {
  mesh_.colours.clear();
  const Frame near = test::frame_of_wall(plain_red);
  Frame far = test::frame_of_wall([](double, double) { return Rgb8{20, 200, 40}; });
  for (float& depth : far.depth_m.pixels()) depth = 2.5f;
  TextureBaker baker(mesh_, atlas_, {0.01, 3, NoiseModel{0.001, 0, 0}});
  for (int i = 0; i < 3; ++i) {
    Pose T_world_camera = Pose::Identity();
    T_world_camera.translation().z() = -1.5;
    baker.add(far, T_world_camera);
  }
  for (int i = 0; i < 4; ++i) baker.add(near, Pose::Identity());
  for_each(baker.bake(), [&](const Eigen::Vector3f&, Rgb8 colour) { EXPECT_LE(difference(colour, kRed), 2); });
}

TEST_F(Bake, IsTheSameForAnyNumberOfThreads) {
  const std::vector<Frame> frames = {test::frame_of_wall(checks), test::frame_of_wall(plain_red)};
  const BakedTexture many = baked(frames);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(many.image, baked(frames).image);
}

TEST_F(Bake, AMeshWithoutNormalsIsSeenAllTheSame) {
  mesh_.normals.clear();
  EXPECT_DOUBLE_EQ(baked({test::frame_of_wall(checks)}).seen_share, 1);
}

TEST_F(Bake, OddFramesDoNoHarm) {
  Frame tiny = test::frame_of_wall(checks);
  tiny.colour->image = ColourImage(1, 1, kRed);
  tiny.colour->intrinsics = {1, 1, 1, 1, 0, 0};
  Frame blind = test::frame_of_wall(checks);
  for (float& depth : blind.depth_m.pixels()) depth = 0;
  Frame narrow = test::frame_of_wall(checks);
  narrow.depth_m = DepthImage(2, 1, 1.0f);
  narrow.intrinsics = {2, 1, 3, 3, 0.5, 0};
  Frame mirrored = test::frame_of_wall(checks);
  mirrored.intrinsics.fy = mirrored.colour->intrinsics.fy = -500;
  EXPECT_EQ(baked({tiny, blind}).seen_share, 0);
  EXPECT_EQ(baked({narrow}).frames, 1u);
  EXPECT_DOUBLE_EQ(baked({mirrored}).seen_share, 1);
  EXPECT_EQ(baked({}).seen_share, 0);
}

TEST(TexelSize, IsThreeQuartersOfThePixelThatIsNearest) {
  const Frame frame = test::frame_of_wall(checks);
  Pose far = Pose::Identity();
  far.translation().z() = -3;
  const std::vector<Pose> poses = {far, Pose::Identity()};
  EXPECT_NEAR(*fitting_texel_m(test::wall(), frame.intrinsics, poses), 0.75 / 500, 1e-9);
  Pose away = Pose::Identity();
  away.translation().z() = 2;
  EXPECT_FALSE(fitting_texel_m(test::wall(), frame.intrinsics, std::vector<Pose>{away}));
  EXPECT_FALSE(fitting_texel_m({}, frame.intrinsics, poses));
}

TEST(TextureFill, GivesEachPixelTheColourOfTheNearest) {
  ColourImage image(9, 5, Rgb8{});
  Image<std::uint8_t> covered(9, 5, 0);
  image.at(1, 2) = kRed;
  image.at(7, 2) = kGrey;
  covered.at(1, 2) = covered.at(7, 2) = 1;
  fill_uncovered(covered, image);
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 9; ++x) {
      if (x != 4) {
        EXPECT_EQ(image.at(x, y), x < 4 ? kRed : kGrey) << x << ' ' << y;
      }
    }
  }
  const ColourImage whole = image;
  fill_uncovered(Image<std::uint8_t>(9, 5, 0), image);
  EXPECT_EQ(image, whole);
}

}  // namespace
}  // namespace scanknit
