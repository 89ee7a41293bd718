#include "fusion/track/colour_lateness.h"

#include <gtest/gtest.h>

namespace scanknit {
namespace {

ColourLateness after(int frames, double later_s, double moved_px = 10) {
  ColourLateness lateness;
  for (int i = 0; i < frames; ++i) lateness.learn(i % 2 == 0 ? later_s : -later_s, moved_px);
  return lateness;
}

TEST(ColourLateness, IsNotKnownBeforeTheCameraHasMoved) {
  EXPECT_FALSE(ColourLateness().is_none());
  EXPECT_FALSE(after(4, 0).is_none());
}

TEST(ColourLateness, IsNoneWhereColourComesWithDepth) {
  EXPECT_TRUE(after(5, 0.001).is_none());
  EXPECT_TRUE(after(200, 0.001).is_none());
}

TEST(ColourLateness, IsSeenWhereColourIsLateOrJitters) {
  EXPECT_FALSE(after(5, 0.004).is_none());
  EXPECT_FALSE(after(200, 0.004).is_none());
}

TEST(ColourLateness, IsSeenInAFewFramesOfAQuickTurnAfterALongSlowWalk) {
  ColourLateness lateness = after(300, 0.001, 5);
  for (int i = 0; i < 3; ++i) lateness.learn(0.01, 20);
  EXPECT_FALSE(lateness.is_none());
}

TEST(ColourLateness, IsNotTakenFromFramesThatHardlyMove) {
  ColourLateness lateness = after(20, 0.001, 20);
  for (int i = 0; i < 20; ++i) lateness.learn(0.005, 1);
  EXPECT_TRUE(lateness.is_none());
}

}  // namespace
}  // namespace scanknit
