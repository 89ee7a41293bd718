#include "fusion/register/scene_change.h"

#include <gtest/gtest.h>

#include "tests/fusion/small_world.h"

namespace scanknit {
namespace {

using test::look;
using test::motion;
using test::on_circle;
using test::small_room;
using test::World;

const NoiseModel kNoise;

double changed(const World& now, const World& before, const Pose& T_model_frame) {
  const SurfacePyramid frame = pyramid_of(look(now, on_circle(0)), kNoise);
  const SurfacePyramid model = pyramid_of(look(before, on_circle(0)), kNoise);
  return changed_share(frame.levels[1], model.levels[1], T_model_frame, {}, kNoise);
}

TEST(SceneChange, IsWhatCameOrWent) {
  const World with_ball = small_room().add_ball({0.0, -0.3, -0.5}, 0.1);
  const DepthImage open_m = look(small_room(), on_circle(0)).depth_m;
  const DepthImage hidden_m = look(with_ball, on_circle(0)).depth_m;
  double pixels = 0;
  for (int y = 0; y < open_m.height(); ++y) {
    for (int x = 0; x < open_m.width(); ++x) pixels += open_m.at(x, y) - hidden_m.at(x, y) > 0.1f;
  }
  const double share = pixels / static_cast<double>(open_m.pixels().size());
  EXPECT_EQ(changed(small_room(), small_room(), Pose::Identity()), 0);
  EXPECT_NEAR(changed(with_ball, small_room(), Pose::Identity()), share, 0.01);
  EXPECT_NEAR(changed(small_room(), with_ball, Pose::Identity()), share, 0.01);
}

// Tracking takes 0.06 and more for a change.
TEST(SceneChange, IsNotAPoseThatIsALittleWrong) {
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d way = Eigen::Vector3d::Unit(axis);
    EXPECT_LT(changed(small_room(), small_room(), motion({0, 0, 0}, 0.02 * way)), 0.02) << "axis " << axis;
    EXPECT_LT(changed(small_room(), small_room(), motion(0.01 * way, {0, 0, 0})), 0.02) << "axis " << axis;
  }
}

}  // namespace
}  // namespace scanknit
