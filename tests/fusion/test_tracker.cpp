#include "fusion/track/tracker.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "fusion/integrate/integrate.h"
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
using test::World;

constexpr double kVoxel = 0.02;

/// Tracks and fuses frame after frame, as the pipeline does.
class Scan {
 public:
  explicit Scan(World world = small_room(), PosePrior prior = PosePrior::kIgnore, bool has_colour = true)
      : world_(std::move(world)), tracker_({.prior = prior}), has_colour_(has_colour), volume_(make_volume()) {}

  TrackResult see(Frame frame) {
    frame.timestamp_ns = ++frames_;
    const TrackResult result = tracker_.track(frame, volume_);
    if (!result.is_lost()) {
      EXPECT_TRUE(integrate(frame, result.T_world_camera, volume_));
    }
    return result;
  }
  TrackResult see_from(const Pose& T_world_camera) { return see(look(world_, T_world_camera, has_colour_)); }

  /// The lens is covered.
  TrackResult see_nothing() {
    Frame frame = look(World(), Pose::Identity(), has_colour_);
    return see(std::move(frame));
  }
  /// The first frame tells the tracker where the world is.
  TrackResult begin_at(const Pose& T_world_camera) {
    Frame frame = look(world_, T_world_camera, has_colour_);
    frame.T_world_camera = T_world_camera;
    return see(std::move(frame));
  }
  TsdfVolume& volume() { return volume_; }

 private:
  static TsdfVolume make_volume() {
    FusionConfig config;
    config.voxel_size_m = kVoxel;
    auto volume = TsdfVolume::create(config);
    EXPECT_TRUE(volume);
    return std::move(volume).value();
  }
  World world_;
  Tracker tracker_;
  bool has_colour_;
  TsdfVolume volume_;
  std::int64_t frames_ = 0;
};

TEST(Tracker, BeginsAtTheOriginOrWhereTheRecordingSays) {
  EXPECT_EQ(Scan().see_from(on_circle(5)).T_world_camera.matrix(), Pose::Identity().matrix());
  EXPECT_EQ(Scan().begin_at(on_circle(5)).T_world_camera.matrix(), on_circle(5).matrix());
}

class Orbit : public ::testing::TestWithParam<bool> {};

TEST_P(Orbit, OfThreeDegreesAFrameIsFollowedToItsEnd) {
  Scan scan(small_room(), PosePrior::kIgnore, GetParam());
  ASSERT_EQ(scan.begin_at(on_circle(0)).state, TrackState::kOk);
  for (int step = 1; step <= 120; ++step) {
    const TrackResult result = scan.see_from(on_circle(step));
    ASSERT_EQ(result.state, TrackState::kOk) << "step " << step << ": " << to_string(result.reason);
    ASSERT_LT(distance_m(result.T_world_camera, on_circle(step)), kVoxel / 4) << "step " << step;
  }
}

INSTANTIATE_TEST_SUITE_P(Tracker, Orbit, ::testing::Bool(),
                         [](const auto& test) { return test.param ? "WithColour" : "ByDepthAlone"; });

TEST(Tracker, FollowsASuddenTurnOfEightDegrees) {
  Scan scan;
  (void)scan.begin_at(on_circle(0));
  (void)scan.see_from(on_circle(1));
  const Pose turned = on_circle(1) * motion({0, 8 * test::kPi / 180, 0}, {0, 0, 0});
  const TrackResult result = scan.see_from(turned);
  EXPECT_EQ(result.state, TrackState::kOk) << to_string(result.reason);
  EXPECT_LT(distance_m(result.T_world_camera, turned), kVoxel / 4);
}

TEST(Tracker, KeepsThePoseOfPicturesThatComeTwice) {
  Scan scan;
  (void)scan.begin_at(on_circle(0));
  (void)scan.see_from(on_circle(1));
  const TrackResult once = scan.see_from(on_circle(2));
  const TrackResult twice = scan.see_from(on_circle(2));
  EXPECT_EQ(twice.T_world_camera.matrix(), once.T_world_camera.matrix());
  EXPECT_EQ(twice.state, TrackState::kOk);
  EXPECT_EQ(twice.inlier_share, once.inlier_share);
  const TrackResult next = scan.see_from(on_circle(4));  // the camera has gone on
  EXPECT_EQ(next.state, TrackState::kOk) << to_string(next.reason);
  EXPECT_LT(distance_m(next.T_world_camera, on_circle(4)), kVoxel / 4);
}

TEST(Tracker, IsLostUnderACoveredLensAndFindsItsPlaceAgain) {
  Scan scan;
  (void)scan.begin_at(on_circle(0));
  for (int step = 1; step <= 10; ++step) ASSERT_FALSE(scan.see_from(on_circle(step)).is_lost());
  const std::size_t voxels = scan.volume().active_voxels();
  for (int i = 0; i < 5; ++i) {
    const TrackResult result = scan.see_nothing();
    EXPECT_EQ(result.state, TrackState::kLost);
    EXPECT_EQ(result.reason, TrackReason::kNothingSeen);
  }
  EXPECT_EQ(scan.volume().active_voxels(), voxels);
  const TrackResult result = scan.see_from(on_circle(11));
  EXPECT_EQ(result.state, TrackState::kRecovered);
  EXPECT_LT(distance_m(result.T_world_camera, on_circle(11)), kVoxel / 2);
  EXPECT_EQ(scan.see_from(on_circle(12)).state, TrackState::kOk);
}

TEST(Tracker, FindsAPlaceItHasSeenAfterLongBlindness) {
  Scan scan;
  (void)scan.begin_at(on_circle(0));
  for (int step = 1; step <= 30; ++step) ASSERT_FALSE(scan.see_from(on_circle(step)).is_lost());
  (void)scan.see_nothing();
  for (const int step : {2, 3}) {  // 84 degrees from where it was lost
    EXPECT_EQ(scan.see_from(on_circle(step)).reason, TrackReason::kMakingSure);
  }
  const TrackResult result = scan.see_from(on_circle(4));
  EXPECT_EQ(result.state, TrackState::kRecovered) << to_string(result.reason);
  EXPECT_LT(distance_m(result.T_world_camera, on_circle(4)), kVoxel / 2);
}

TEST(Tracker, IsLostRatherThanWrongAfterAJumpToWhereItHasNeverBeen) {
  Scan scan;
  (void)scan.begin_at(on_circle(0));
  for (int step = 1; step <= 20; ++step) ASSERT_FALSE(scan.see_from(on_circle(step)).is_lost());
  int lost = 0;
  for (int step = 61; step <= 125; ++step) {  // 40 frames are missing
    const TrackResult result = scan.see_from(on_circle(step));
    if (result.is_lost()) {
      ++lost;
      EXPECT_NE(result.reason, TrackReason::kNone);
      continue;
    }
    ASSERT_LT(distance_m(result.T_world_camera, on_circle(step)), kVoxel) << "step " << step;
  }
  EXPECT_GT(lost, 0);
  EXPECT_FALSE(scan.see_from(on_circle(126)).is_lost());  // back where it began
}

TEST(Tracker, SaysThatTooFewPointsOrACloseSurfaceAreTheReason) {
  const auto reason_at = [](double depth_m) {
    const World wall = World().add_wall({0, 0, -1}, -depth_m);
    Scan scan(wall);
    (void)scan.see_from(Pose::Identity());
    Frame frame = look(wall, Pose::Identity());
    for (int y = 2; y < frame.depth_m.height(); ++y) {
      for (float& z : frame.depth_m.row(y)) z = 0;
    }
    const TrackResult result = scan.see(std::move(frame));
    EXPECT_TRUE(result.is_lost());
    return result.reason;
  };
  EXPECT_EQ(reason_at(0.4), TrackReason::kTooClose);
  EXPECT_EQ(reason_at(1.5), TrackReason::kTooFewPoints);
}

TEST(Tracker, DoesNotMoveAlongABareWall) {
  Scan scan(bare_wall(), PosePrior::kIgnore, /*has_colour=*/false);
  (void)scan.see_from(Pose::Identity());
  for (int step = 1; step <= 5; ++step) {
    const TrackResult result = scan.see_from(motion({0, 0, 0}, {0.01 * step, 0, 0.01 * step}));
    EXPECT_EQ(result.state, TrackState::kWeak);
    EXPECT_EQ(result.reason, TrackReason::kFlatScene);
    EXPECT_EQ(result.weak_directions, 3);
    EXPECT_LT(result.T_world_camera.translation().head<2>().norm(), kVoxel / 10);
    EXPECT_NEAR(result.T_world_camera.translation().z(), 0.01 * step, kVoxel / 10);
  }
}

TEST(Tracker, RefinesRecordedPosesALittle) {
  Scan scan(small_room(), PosePrior::kRefine);
  (void)scan.begin_at(on_circle(0));
  for (int step = 1; step <= 10; ++step) {
    Frame frame = look(small_room(), on_circle(step));
    frame.T_world_camera = on_circle(step) * motion({0.01, 0, -0.01}, {0.01, -0.01, 0});
    const TrackResult result = scan.see(std::move(frame));
    EXPECT_EQ(result.state, TrackState::kOk) << to_string(result.reason);
    EXPECT_LT(distance_m(result.T_world_camera, on_circle(step)), kVoxel / 4);
  }
}

TEST(Tracker, DoesNotFollowARecordedPoseThatTheSceneContradicts) {
  Scan scan(small_room(), PosePrior::kRefine);
  (void)scan.begin_at(on_circle(0));
  const auto see = [&](int step, const Pose& error) {
    Frame frame = look(small_room(), on_circle(step));
    frame.T_world_camera = on_circle(step) * error;
    return scan.see(std::move(frame));
  };
  for (int step = 1; step <= 5; ++step) ASSERT_EQ(see(step, Pose::Identity()).state, TrackState::kOk);
  const TrackResult far_off = see(6, motion({0.1, 0, 0.4}, {0, 0, 0}));
  EXPECT_FALSE(far_off.is_lost()) << to_string(far_off.reason);
  EXPECT_LT(distance_m(far_off.T_world_camera, on_circle(6)), kVoxel / 4) << "it fits where the camera is";
  const TrackResult elsewhere = see(7, motion({0.5, 0.5, 0.5}, {0.5, 0.5, 0.5}));
  EXPECT_EQ(elsewhere.state, TrackState::kLost);
  EXPECT_EQ(elsewhere.reason, TrackReason::kRecordedPoseDoesNotFit);
  EXPECT_EQ(see(8, Pose::Identity()).state, TrackState::kOk);
}

TEST(Tracker, KeepsARecordedPoseThatItCannotRefine) {
  Scan scan(small_room(), PosePrior::kRefine);
  (void)scan.begin_at(on_circle(0));
  Frame frame = look(small_room(), on_circle(1));
  frame.T_world_camera = on_circle(60);
  const TrackResult result = scan.see(std::move(frame));
  EXPECT_EQ(result.state, TrackState::kWeak);
  EXPECT_EQ(result.T_world_camera.matrix(), on_circle(60).matrix());
}

TEST(Tracker, GivesTheSameBitsForAnyNumberOfThreads) {
  const auto path_with_threads = [](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    Scan scan;
    std::vector<Eigen::Matrix4d> path;
    for (const int step : {0, 1, 2, 3, 4, 40, 2, 3, 4, 5}) {  // lost and found too
      path.push_back(scan.see_from(on_circle(step)).T_world_camera.matrix());
    }
    return path;
  };
  const auto one = path_with_threads(1);
  EXPECT_EQ(path_with_threads(2), one);
  EXPECT_EQ(path_with_threads(8), one);
}

}  // namespace
}  // namespace scanknit
