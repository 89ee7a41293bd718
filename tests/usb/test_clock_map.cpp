#include <gtest/gtest.h>

#include <cstdlib>
#include <random>

#include "acquire/usb/clock_map.h"

namespace scanknit::test {
namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kSecond = 1'000 * kMs;
constexpr std::uint32_t kMicrosecondClock = 1'000'000;

TEST(ClockMap, KnowsNothingBeforeTheFirstPair) {
  EXPECT_FALSE(ClockMap().host_of(1));
  EXPECT_FALSE(ClockMap().device_of(1));
}

TEST(ClockMap, IsNotMovedByLateFrames) {
  // 80 ppm of skew, 5 ms of least delay; four frames of five are up to 30 ms late.
  std::mt19937 random(7);
  std::uniform_real_distribution<double> late(0, 30e6);
  ClockMap map;
  const auto host_at = [](std::int64_t device) { return device + device / 12500 + 1000 * kSecond + 5 * kMs; };
  std::int64_t device = 0;
  for (int i = 0; i < 400; ++i) {
    device = i * 33 * kMs;
    map.add(device, host_at(device) + (i % 5 == 0 ? 0 : static_cast<std::int64_t>(late(random))));
  }
  EXPECT_LT(std::abs(*map.host_of(device) - host_at(device)), kMs / 20);
  EXPECT_LT(std::abs(*map.device_of(host_at(device)) - device), kMs / 20);
}

TEST(ClockMap, TakesNoSkewFromTwoPairs) {
  ClockMap map;
  map.add(0, 10 * kMs);
  map.add(33 * kMs, 40 * kMs);  // 3 ms less delay in 33 ms: no crystal does that
  EXPECT_EQ(map.host_of(66 * kMs), 73 * kMs);
}

TEST(DeviceClock, GoesOnWhenTheCounterWraps) {
  DeviceClock clock(kMicrosecondClock);
  const auto before = clock.stamp(0xFFFFFFFF - 9'999, 0);
  const auto after = clock.stamp(23'333, 33'333'000);
  EXPECT_FALSE(after.is_jump);
  EXPECT_EQ(after.device_ns - before.device_ns, 33'333'000);
}

TEST(DeviceClock, CountsWholeRangesOfALongPause) {
  DeviceClock clock(48'000'000);  // wraps after 89.5 s
  const auto before = clock.stamp(0, 0);
  const std::uint64_t ticks = 200ull * 48'000'000;
  const auto after = clock.stamp(static_cast<std::uint32_t>(ticks), 200 * kSecond);
  EXPECT_FALSE(after.is_jump);
  EXPECT_EQ(after.device_ns - before.device_ns, 200 * kSecond);
}

TEST(DeviceClock, SaysThatItJumpedAndGoesOn) {
  for (const std::int64_t jump_us : {-3'000'000, 5'000'000, 1'000'000'000}) {
    DeviceClock clock(kMicrosecondClock);
    std::int64_t last = 0;
    int jumps = 0;
    for (int i = 0; i < 60; ++i) {
      const std::int64_t us = 10'000'000 + i * 33'333 + (i >= 30 ? jump_us : 0);
      const auto stamp = clock.stamp(static_cast<std::uint32_t>(us), i * 33'333'000ll);
      jumps += stamp.is_jump ? 1 : 0;
      const double step_ns = static_cast<double>(stamp.device_ns - last);
      EXPECT_TRUE(i == 0 || std::abs(step_ns - 33'333'000) < 1000) << i << ": " << step_ns;
      last = stamp.device_ns;
    }
    EXPECT_EQ(jumps, 1) << jump_us;
  }
}

TEST(DeviceClock, RunsOnTheHostsWhenTheCamerasIsFrozen) {
  DeviceClock clock(kMicrosecondClock);
  const auto first = clock.stamp(5, 0);
  EXPECT_FALSE(first.is_jump);
  for (int i = 1; i < 10; ++i) {
    const auto stamp = clock.stamp(5, i * 33 * kMs);
    EXPECT_TRUE(stamp.is_jump);
    EXPECT_EQ(stamp.device_ns - first.device_ns, i * 33 * kMs);
  }
}

TEST(DeviceClock, IsTheHostsWhenFramesHaveNoTime) {
  DeviceClock clock(kMicrosecondClock);
  EXPECT_EQ(clock.stamp(std::nullopt, 40).device_ns, 40);
  EXPECT_EQ(clock.stamp(std::nullopt, 40).device_ns, 41) << "never the same twice";
}

}  // namespace
}  // namespace scanknit::test
