#include "fusion/register/icp.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "tests/fusion/small_world.h"

namespace scanknit {
namespace {

using test::angle_rad;
using test::bare_wall;
using test::distance_m;
using test::look;
using test::motion;
using test::on_circle;
using test::small_room;
using test::view_of;
using test::World;

IcpResult register_views(const World& world, const Pose& from, const Pose& to, bool has_colour,
                         const Pose& start = Pose::Identity()) {
  const NoiseModel noise;
  return register_frame(pyramid_of(look(world, to, has_colour), noise),
                        pyramid_of(view_of(world, from, has_colour), noise), start, {noise});
}

struct Motion {
  const char* name;
  Eigen::Vector3d turn_deg, shift_m;
};
std::ostream& operator<<(std::ostream& out, const Motion& motion) {
  return out << motion.name;
}

class KnownMotion : public ::testing::TestWithParam<std::tuple<Motion, bool>> {};

TEST_P(KnownMotion, IsRecovered) {
  const auto& [moved, has_colour] = GetParam();
  const Pose truth = motion(moved.turn_deg * test::kPi / 180, moved.shift_m);
  const Pose eye = on_circle(0);
  const IcpResult result = register_views(small_room(), eye, eye * truth, has_colour);
  // A pixel of this small picture is 8 mm wide at 1 m: a tenth of it.
  EXPECT_LT(distance_m(result.T_model_frame, truth), 0.8e-3);
  EXPECT_LT(angle_rad(result.T_model_frame, truth), 1e-3);
  EXPECT_EQ(result.weak_directions, 0);
  EXPECT_GT(result.inlier_share, 0.9);
}

INSTANTIATE_TEST_SUITE_P(Icp, KnownMotion,
                         ::testing::Combine(::testing::Values(Motion{"none", {0, 0, 0}, {0, 0, 0}},
                                                              Motion{"forward", {0, 0, 0}, {0, 0, 0.05}},
                                                              Motion{"sideways", {0, 0, 0}, {0.05, 0.02, 0}},
                                                              Motion{"turned", {1, 3, 0.5}, {0, 0, 0}},
                                                              Motion{"rolled", {0, 0, 4}, {0, 0, 0}},
                                                              Motion{"orbit", {0, -3, 0}, {0.05, 0, 0}}),
                                            ::testing::Bool()),
                         [](const auto& test) {
                           return std::string(std::get<0>(test.param).name) +
                                  (std::get<1>(test.param) ? "WithColour" : "ByDepthAlone");
                         });

TEST(Icp, FindsThePoseOfTheMiddleRowOfARollingShutter) {
  const NoiseModel noise;
  const Pose before = on_circle(0);
  const Pose truth = motion({0.02, 0.06, 0.01}, {0.04, 0.02, 0});  // 100 degrees a second at 30 frames a second
  const MovingCamera moving{Pose::Identity(), 0.9};
  const Frame frame = look(small_room(), before * truth, true, test::small_camera(), moving.motion(truth) * 0.9);
  const SurfacePyramid seen = pyramid_of(frame, noise), model = pyramid_of(view_of(small_room(), before), noise);
  IcpConfig config{noise};
  const Pose as_if_at_once = register_frame(seen, model, Pose::Identity(), config).T_model_frame;
  config.moving = moving;
  const Pose found = register_frame(seen, model, Pose::Identity(), config).T_model_frame;
  // As exact as without a shutter: a tenth of a pixel.
  EXPECT_LT(distance_m(found, truth), 0.8e-3);
  EXPECT_LT(angle_rad(found, truth), 1e-3);
  EXPECT_GT(distance_m(as_if_at_once, truth), 3e-3) << "else the shutter is not seen in this test";
}

TEST(Icp, FindsWhenColourWasTaken) {
  const NoiseModel noise;
  const Pose before = on_circle(0);
  const Pose truth = motion({0.02, 0.06, 0.01}, {0.04, 0.02, 0});  // 100 degrees a second at 30 frames a second
  const MovingCamera moving{Pose::Identity(), 0, 0.3};
  constexpr double kLater = 0.4;
  Frame frame = look(small_room(), before * truth, true);
  frame.colour = look(small_room(), before * truth * moving.motion(truth).after(kLater), true).colour;
  const SurfacePyramid seen = pyramid_of(frame, noise), model = pyramid_of(view_of(small_room(), before), noise);
  IcpConfig config{noise};
  const Pose as_if_at_once = register_frame(seen, model, Pose::Identity(), config).T_model_frame;
  config.moving = moving;
  const IcpResult found = register_frame(seen, model, Pose::Identity(), config);
  EXPECT_NEAR(found.colour_later, kLater, 0.04);
  EXPECT_LT(distance_m(found.T_model_frame, truth), 0.8e-3);
  EXPECT_LT(angle_rad(found.T_model_frame, truth), 1e-3);
  EXPECT_GT(distance_m(as_if_at_once, truth), 2e-3) << "else the time is not seen in this test";
}

/// Depth that is off by up to a few sigma, alike over squares of 14 pixels, as of a sensor that matches windows.
void disturb(const NoiseModel& noise, DepthImage& depth_m) {
  constexpr int kAlike = 14;
  constexpr float kMostSigmas = 3;
  for (int y = 0; y < depth_m.height(); ++y) {
    for (int x = 0; x < depth_m.width(); ++x) {
      const int square = 7 * (x / kAlike) + 3 * (y / kAlike);
      const float off = kMostSigmas * (static_cast<float>(square * square % 11) / 5 - 1);  // -1 to 1
      float& z_m = depth_m.at(x, y);
      z_m += off * static_cast<float>(noise.sigma_m(static_cast<double>(z_m)));
    }
  }
}

TEST(Icp, IsHeldByTimelyColourWhereErrorsOfDepthAreAlike) {
  const NoiseModel noise;
  const Pose eye = on_circle(0);
  const Pose truth = motion({0.01, 0.02, 0.005}, {0.02, 0.01, 0});
  Frame frame = look(small_room(), eye * truth);
  disturb(noise, frame.depth_m);
  const SurfacePyramid seen = pyramid_of(frame, noise), model = pyramid_of(view_of(small_room(), eye), noise);
  IcpConfig config{noise};
  const IcpResult as_one_of_many = register_frame(seen, model, Pose::Identity(), config);
  config.colour_is_timely = true;
  const IcpResult held = register_frame(seen, model, Pose::Identity(), config);
  // Along the line of sight only depth holds it.
  const auto sideways_m = [&](const IcpResult& found) {
    return (truth.inverse() * found.T_model_frame).translation().head<2>().norm();
  };
  EXPECT_LT(angle_rad(held.T_model_frame, truth), 0.5 * angle_rad(as_one_of_many.T_model_frame, truth));
  EXPECT_LT(sideways_m(held), 0.5 * sideways_m(as_one_of_many));
}

TEST(Icp, SaysHowLateColourSeemsToBe) {
  const NoiseModel noise;
  const Pose before = on_circle(0);
  const Pose truth = motion({0.02, 0.06, 0.01}, {0.04, 0.02, 0});  // 100 degrees a second at 30 frames a second
  const SurfacePyramid model = pyramid_of(view_of(small_room(), before), noise);
  IcpConfig config{noise};
  config.moving = MovingCamera{Pose::Identity()};
  config.asks_if_colour_is_late = true;
  for (const double later : {0.0, 0.1, -0.2}) {
    Frame frame = look(small_room(), before * truth);
    frame.colour = look(small_room(), before * truth * config.moving->motion(truth).after(later)).colour;
    const IcpResult found = register_frame(pyramid_of(frame, noise), model, Pose::Identity(), config);
    ASSERT_TRUE(found.colour_seems_later);
    EXPECT_NEAR(*found.colour_seems_later, later, 0.03);  // 1 ms
    EXPECT_EQ(found.colour_later, 0) << "it is not searched for";
  }
  config.moving = MovingCamera{truth};  // the camera stands still
  EXPECT_FALSE(
      register_frame(pyramid_of(look(small_room(), before * truth), noise), model, truth, config).colour_seems_later);
}

TEST(Icp, FindsThreeWeakDirectionsBeforeABareWallAndDoesNotMoveAlongThem) {
  const Pose truth = motion({0, 0, 0}, {0.03, 0.01, 0.02});
  const IcpResult result = register_views(bare_wall(), Pose::Identity(), truth, /*has_colour=*/false);
  EXPECT_EQ(result.weak_directions, 3);
  EXPECT_NEAR(result.T_model_frame.translation().x(), 0, 1e-4);
  EXPECT_NEAR(result.T_model_frame.translation().y(), 0, 1e-4);
  EXPECT_NEAR(result.T_model_frame.translation().z(), 0.02, 1e-4);
}

TEST(Icp, IsHeldByTheColourOfAWall) {
  const Pose truth = motion({0, 0, 0.02}, {0.03, 0.01, 0.02});
  const IcpResult result = register_views(bare_wall(), Pose::Identity(), truth, /*has_colour=*/true);
  EXPECT_EQ(result.weak_directions, 0);
  EXPECT_LT(distance_m(result.T_model_frame, truth), 1e-3);
}

TEST(Icp, TakesNoNoticeOfAChangeOfExposure) {
  const Pose truth = motion({0, 0, 0.02}, {0.03, 0.01, 0.02});
  const NoiseModel noise;
  ModelView brighter = view_of(bare_wall(), Pose::Identity());
  for (float& intensity : brighter.intensity.pixels()) intensity += 0.1f;
  const IcpResult result = register_frame(pyramid_of(look(bare_wall(), truth), noise), pyramid_of(brighter, noise),
                                          Pose::Identity(), {noise});
  EXPECT_LT(distance_m(result.T_model_frame, truth), 1e-3);
}

TEST(Icp, LooksUpColourThroughTheColourCamera) {
  const Pose truth = motion({0, 0, 0}, {0.03, 0.01, 0.02});
  const NoiseModel noise;
  // A colour camera 4 cm beside the depth camera, of another size.
  const Pose T_depth_colour = motion({0, 0.02, 0}, {0.04, 0, 0});
  const CameraIntrinsics colour_camera{200, 150, 170, 170, 99.5, 74.5};
  Frame frame = look(bare_wall(), truth);
  frame.colour = look(bare_wall(), truth * T_depth_colour, true, colour_camera).colour;
  frame.colour->T_colour_depth = T_depth_colour.inverse();
  const IcpResult result = register_frame(
      pyramid_of(frame, noise), pyramid_of(view_of(bare_wall(), Pose::Identity()), noise), Pose::Identity(), {noise});
  EXPECT_LT(distance_m(result.T_model_frame, truth), 1e-3);
}

TEST(Icp, SaysHowLittleFits) {
  const Pose eye = on_circle(0);
  const NoiseModel noise;
  Frame frame = look(small_room(), eye);
  for (float& z : frame.depth_m.pixels()) z *= 0.5f;  // something else stands before the camera
  const IcpResult result = register_frame(pyramid_of(frame, noise), pyramid_of(view_of(small_room(), eye), noise),
                                          Pose::Identity(), {noise});
  EXPECT_LT(result.inlier_share, 0.2);
}

TEST(Icp, StaysWhereItIsWithoutAModel) {
  const NoiseModel noise;
  const Pose start = motion({0, 0.1, 0}, {0.1, 0.2, 0.3});
  const IcpResult result = register_frame(pyramid_of(look(small_room(), on_circle(0)), noise),
                                          pyramid_of(view_of(World(), Pose::Identity()), noise), start, {noise});
  EXPECT_LT(distance_m(result.T_model_frame, start), 1e-12);
  EXPECT_EQ(result.overlap, 0);
  EXPECT_EQ(result.weak_directions, 6);
}

TEST(Icp, HandlesAMirroredCamera) {
  const CameraIntrinsics mirrored{160, 120, 130, -130, 79.5, 59.5};  // ICL-NUIM
  const Pose eye = on_circle(0);
  const Pose truth = motion({0.01, 0.03, 0}, {0.02, 0.01, 0.02});
  const NoiseModel noise;
  const IcpResult result =
      register_frame(pyramid_of(look(small_room(), eye * truth, true, mirrored), noise),
                     pyramid_of(view_of(small_room(), eye, true, mirrored), noise), Pose::Identity(), {noise});
  EXPECT_LT(distance_m(result.T_model_frame, truth), 0.8e-3);
}

TEST(Icp, GivesTheSameBitsForAnyNumberOfThreads) {
  const auto with_threads = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return register_views(small_room(), on_circle(0), on_circle(1), true).T_model_frame.matrix();
  };
  const Eigen::Matrix4d one = with_threads(1);
  EXPECT_EQ(with_threads(2), one);
  EXPECT_EQ(with_threads(8), one);
}

}  // namespace
}  // namespace scanknit
