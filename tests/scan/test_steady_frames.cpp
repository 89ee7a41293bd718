// Which frames a texture is baked from.
#include <gtest/gtest.h>

#include <vector>

#include "scan/frames/steady_frames.h"

namespace scanknit {
namespace {

/// Frames along x, the first as number `first`.
void add(std::uint64_t first, const std::vector<double>& x_m, PosesBySequence& poses) {
  for (const double x : x_m) {
    Pose pose = Pose::Identity();
    pose.translation().x() = x;
    poses[first++] = pose;
  }
}

std::vector<std::uint64_t> numbers(const PosesBySequence& poses) {
  std::vector<std::uint64_t> all;
  for (const auto& [sequence, pose] : poses) all.push_back(sequence);
  return all;
}

TEST(SteadyFrames, AreAllWhereThereAreNoMoreThanAsked) {
  PosesBySequence poses;
  add(5, {0, 1, 5, 6}, poses);
  EXPECT_EQ(numbers(steadiest(poses, 4)), numbers(poses));
  EXPECT_TRUE(steadiest({}, 4).empty());
}

TEST(SteadyFrames, AreThoseOfEachFewInWhichTheCameraMovedLeast) {
  PosesBySequence poses;
  add(0, {0, 0.3, 0.6, 0.61, 0.62, 0.9, 1.2, 1.21, 1.22, 1.5, 1.8, 2.1}, poses);
  EXPECT_EQ(numbers(steadiest(poses, 3)), (std::vector<std::uint64_t>{3, 7, 8}));
}

TEST(SteadyFrames, TheFirstAndTheLastAreNoSteadierForHavingOneNeighbour) {
  PosesBySequence poses;
  add(0, {0, 0.10, 0.18, 0.27, 0.36, 0.44, 0.54, 0.64}, poses);  // 10 cm a frame at the ends
  EXPECT_EQ(numbers(steadiest(poses, 2)), (std::vector<std::uint64_t>{2, 4}));
}

TEST(SteadyFrames, AGapDoesNotCountAsMotion) {
  PosesBySequence poses;
  add(0, {0, 0.1, 0.2}, poses);
  add(10, {0.3, 0.4, 0.5}, poses);  // while none was tracked the camera crept on
  EXPECT_EQ(numbers(steadiest(poses, 2)), (std::vector<std::uint64_t>{2, 10}));
}

}  // namespace
}  // namespace scanknit
