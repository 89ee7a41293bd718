#include <gtest/gtest.h>

#include "acquire/silence_watch.h"

namespace scanknit {
namespace {

using Verdict = SilenceWatch::Verdict;

constexpr std::int64_t kTick_ns = 100'000'000;  // between two looks
constexpr std::int64_t kTicks = SilenceWatch::kSilence.count() / kTick_ns;

/// Looks ten times a second at a camera; the clock is the test's.
class WatchedCamera {
 public:
  void send_picture() { picture_ns_ = now_ns_; }
  Verdict look() {
    now_ns_ += kTick_ns;
    const Verdict verdict = watch_.look(picture_ns_, now_ns_);
    if (verdict == Verdict::kRestart) watch_.restarted(now_ns_);
    return verdict;
  }
  /// The first verdict that is not kNothing, in at most `looks`.
  Verdict first_within(std::int64_t looks) {
    for (; looks > 0; --looks) {
      if (const Verdict verdict = look(); verdict != Verdict::kNothing) return verdict;
    }
    return Verdict::kNothing;
  }
  void sleep(std::int64_t time_ns) { now_ns_ += time_ns; }

 private:
  std::int64_t now_ns_ = 1'000'000'000'000;
  std::int64_t picture_ns_ = 0;
  SilenceWatch watch_{now_ns_};
};

TEST(SilenceWatch, LeavesACameraAloneThatSends) {
  WatchedCamera camera;
  for (int i = 0; i < 10 * kTicks; ++i) {
    camera.send_picture();
    EXPECT_EQ(camera.look(), Verdict::kNothing);
  }
}

TEST(SilenceWatch, GivesTheFirstPictureItsTime) {
  WatchedCamera camera;
  EXPECT_EQ(camera.first_within(kTicks), Verdict::kNothing);
  EXPECT_EQ(camera.look(), Verdict::kRestart);
}

TEST(SilenceWatch, GivesUpACameraThatStaysSilentAfterTwoRestarts) {
  WatchedCamera camera;
  camera.send_picture();
  EXPECT_EQ(camera.first_within(kTicks + 1), Verdict::kRestart);
  EXPECT_EQ(camera.first_within(kTicks), Verdict::kNothing) << "a restart is given the same time";
  EXPECT_EQ(camera.look(), Verdict::kRestart);
  EXPECT_EQ(camera.first_within(kTicks + 1), Verdict::kGiveUp);
}

TEST(SilenceWatch, BeginsAnewWithACameraThatRecovered) {
  WatchedCamera camera;
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(camera.first_within(kTicks + 1), Verdict::kRestart);
    EXPECT_EQ(camera.look(), Verdict::kNothing);
    camera.send_picture();
    EXPECT_EQ(camera.look(), Verdict::kRecovered);
  }
}

TEST(SilenceWatch, DoesNotBlameTheCameraForABusyComputer) {
  WatchedCamera camera;
  camera.sleep(10 * SilenceWatch::kSilence.count());
  EXPECT_EQ(camera.look(), Verdict::kNothing);
  camera.send_picture();
  EXPECT_EQ(camera.first_within(kTicks), Verdict::kNothing);
}

}  // namespace
}  // namespace scanknit
