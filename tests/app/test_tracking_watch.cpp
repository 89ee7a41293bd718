// A person is told before tracking is lost.
#include <gtest/gtest.h>

#include <string>

#include "app/live/tracking_watch.h"

namespace scanknit {
namespace {

constexpr int kWidth = 64, kHeight = 48;
constexpr std::size_t kMany = kWidth * kHeight / 2, kFew = kWidth * kHeight / 20;

/// Frame n of a camera at 30 frames a second that sees a wall.
Frame frame_of(int n, float depth_m) {
  Frame frame;
  frame.intrinsics = {kWidth, kHeight, 52.5, 52.5, 31.5, 23.5};
  frame.depth_m = DepthImage(kWidth, kHeight, depth_m);
  frame.timestamp_ns = n * 33'333'333LL;
  frame.has_clock = true;
  return frame;
}

Pose turned(double rad) {
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::AngleAxisd(rad, Eigen::Vector3d::UnitY()).toRotationMatrix();
  return pose;
}

Pose moved(double m) {
  Pose pose = Pose::Identity();
  pose.translation().x() = m;
  return pose;
}

std::string reason_of(const std::optional<TrackingCaution>& caution) {
  return caution ? caution->reason : "";
}

TEST(TrackingWatch, IsSilentWhileTheCameraMovesSlowlyAndSeesMuch) {
  TrackingWatch watch;
  for (int n = 0; n < 5; ++n) EXPECT_FALSE(watch.look(frame_of(n, 2), turned(0.02 * n), kMany)) << n;
}

TEST(TrackingWatch, WarnsOfAFastTurn) {
  TrackingWatch watch;
  EXPECT_FALSE(watch.look(frame_of(0, 2), turned(0), kMany));
  EXPECT_EQ(reason_of(watch.look(frame_of(1, 2), turned(0.05), kMany)), "moving fast");
  EXPECT_FALSE(watch.look(frame_of(2, 2), turned(0.06), kMany)) << "it has become slow";
}

TEST(TrackingWatch, WarnsOfAFastMoveCloseToTheSurfaceOnly) {
  TrackingWatch close, far;
  EXPECT_FALSE(close.look(frame_of(0, 0.8f), moved(0), kMany));
  EXPECT_EQ(reason_of(close.look(frame_of(1, 0.8f), moved(0.04), kMany)), "moving fast");
  EXPECT_FALSE(far.look(frame_of(0, 3), moved(0), kMany));
  EXPECT_FALSE(far.look(frame_of(1, 3), moved(0.04), kMany));
}

TEST(TrackingWatch, DoesNotTakeAGapForAFastMove) {
  TrackingWatch watch;
  EXPECT_FALSE(watch.look(frame_of(0, 2), turned(0), kMany));
  EXPECT_FALSE(watch.look(frame_of(30, 2), turned(0.5), kMany));
  watch.forget();
  EXPECT_FALSE(watch.look(frame_of(31, 2), turned(1), kMany));
}

TEST(TrackingWatch, WarnsWhenLittleIsSeen) {
  TrackingWatch watch;
  EXPECT_EQ(reason_of(watch.look(frame_of(0, 2), turned(0), kFew)), "little is seen");
  EXPECT_EQ(reason_of(watch.look(frame_of(1, 0.5f), turned(0), kFew)), "very close");
}

}  // namespace
}  // namespace scanknit
