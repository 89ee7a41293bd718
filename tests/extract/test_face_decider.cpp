#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <string>

#include "extract/cell/cell.h"
#include "extract/cell/face_decider.h"

namespace scanknit {
namespace {

using enum FaceDecision;

/// The six decisions of a cell, as the letters of design/extract.md: `.` not ambiguous, H Highs joined, L Lows joined.
std::string decisions(double isovalue, const std::array<double, 8>& corner) {
  std::string text;
  for (const auto& face : kFaceCorners) {
    std::array<double, 4> value{};
    for (std::size_t i = 0; i < 4; ++i) value[i] = corner[static_cast<std::size_t>(face[i])] - isovalue;
    const FaceDecision decision = decide_face(value);
    text += decision == kUnambiguous ? '.' : decision == kHighsJoined ? 'H' : 'L';
  }
  return text;
}

TEST(FaceDecider, LeavesFacesAloneWhoseHighsAreNeighbours) {
  EXPECT_EQ(decide_face({1, 1, -1, -1}), kUnambiguous);
  EXPECT_EQ(decide_face({1, -1, -1, -1}), kUnambiguous);
  EXPECT_EQ(decide_face({1, 1, 1, 1}), kUnambiguous);
}

TEST(FaceDecider, JoinsHighsWhenTheSaddleIsHigh) {
  EXPECT_EQ(decide_face({2, -1, 2, -1}), kHighsJoined);
}

TEST(FaceDecider, SeparatesHighsWhenTheSaddleIsLow) {
  EXPECT_EQ(decide_face({1, -2, 1, -2}), kHighsSeparated);
}

TEST(FaceDecider, SaddleValueHasAMinusWhereTheLecturePrintsAPlus) {
  // (1 - 2s)(1 - 2t) at isovalue 1/4: the saddle is 0, so Low. With the misprinted plus it would be 1/2, so High.
  EXPECT_EQ(decide_face({1 - 0.25, -1 - 0.25, 1 - 0.25, -1 - 0.25}), kHighsSeparated);
}

TEST(FaceDecider, TieJoinsTheHighsWhicheverDiagonalTheyLieOn) {
  EXPECT_EQ(decide_face({1, -1, 1, -1}), kHighsJoined);
  EXPECT_EQ(decide_face({-1, 1, -1, 1}), kHighsJoined);
}

TEST(FaceDecider, DoesNotDependOnWhereCornersAreCountedFrom) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int i = 0; i < 100000; ++i) {
    const std::array<double, 4> v{uniform(random), -uniform(random), uniform(random), -uniform(random)};
    const FaceDecision decision = decide_face(v);
    ASSERT_EQ(decide_face({v[1], v[2], v[3], v[0]}), decision);
    ASSERT_EQ(decide_face({v[3], v[2], v[1], v[0]}), decision);
    ASSERT_EQ(decide_face({v[2], v[3], v[0], v[1]}), decision);
  }
}

TEST(FaceDecider, AgreesWithTheSaddleOfTheBilinearInterpolant) {
  std::mt19937 random(11);
  for (int i = 0; i < 100000; ++i) {
    const auto number = [&] { return static_cast<double>(random() % 1000 + 1); };  // integers: the products are exact
    const double b00 = number();
    const double b11 = number();
    const double b01 = -number();
    const double b10 = -number();
    const double numerator = b00 * b11 - b10 * b01;  // over a positive denominator
    ASSERT_EQ(decide_face({b00, b10, b11, b01}), numerator >= 0 ? kHighsJoined : kHighsSeparated);
  }
}

/// Ambiguous faces, High on either diagonal.
template <typename Magnitude>
void expect_chord_agrees(std::size_t faces, unsigned seed, const Magnitude& magnitude) {
  std::mt19937_64 random(seed);
  std::size_t joined = 0;
  for (std::size_t i = 0; i < faces; ++i) {
    const double sign = i % 2 == 0 ? 1 : -1;
    const FaceValues value{sign * magnitude(random), -sign * magnitude(random), sign * magnitude(random),
                           -sign * magnitude(random)};
    const FaceDecision decision = decide_face(value);
    ASSERT_EQ(decide_face_by_chord(value), decision) << ::testing::PrintToString(value);
    joined += decision == kHighsJoined ? 1 : 0;
  }
  EXPECT_GT(joined, faces / 10);
  EXPECT_LT(joined, faces - faces / 10);
}

TEST(ChordDecider, AgreesOnTenMillionRandomFaces) {
  expect_chord_agrees(10'000'000, 13, [](auto& random) { return static_cast<double>((random() >> 11) + 1) * 0x1p-53; });
}

TEST(ChordDecider, AgreesOnFacesOfFewLevelsWhereOneInTwentyTies) {
  expect_chord_agrees(1'000'000, 14, [](auto& random) { return static_cast<double>(random() % 8 + 1); });
}

TEST(ChordDecider, AgreesOnFacesWhoseHighsMayLieOnTheIsovalue) {
  std::mt19937 random(15);
  const auto number = [&] { return static_cast<double>(random() % 3); };
  for (int i = 0; i < 100000; ++i) {
    const FaceValues value{number(), -number() - 1, number(), -number() - 1};
    ASSERT_EQ(decide_face_by_chord(value), decide_face(value)) << ::testing::PrintToString(value);
    const FaceValues turned{value[1], value[2], value[3], value[0]};
    ASSERT_EQ(decide_face_by_chord(turned), decide_face(turned)) << ::testing::PrintToString(turned);
  }
}

TEST(ChordDecider, AgreesOnFacesOfValuesOfAllSizes) {
  expect_chord_agrees(1'000'000, 16, [](auto& random) {
    const double mantissa = static_cast<double>(static_cast<float>(random() % 0xFFFFFF + 1));
    return std::ldexp(mantissa, static_cast<int>(random() % 60) - 30);
  });
}

TEST(ChordDecider, AgreesNearTies) {
  expect_chord_agrees(1'000'000, 17, [](auto& random) { return 1 + static_cast<double>(random() % 16) * 0x1p-23; });
}

TEST(ChordDecider, DoesNotDependOnWhereCornersAreCountedFrom) {
  std::mt19937 random(18);
  const auto number = [&] { return static_cast<double>(random() % 20 + 1); };
  for (int i = 0; i < 100000; ++i) {
    const FaceValues v{number(), -number(), number(), -number()};
    const FaceDecision decision = decide_face_by_chord(v);
    ASSERT_EQ(decide_face_by_chord({v[1], v[2], v[3], v[0]}), decision);
    ASSERT_EQ(decide_face_by_chord({v[3], v[2], v[1], v[0]}), decision);
  }
}

TEST(FaceDecider, KnownCells) {
  EXPECT_EQ(decisions(0, {10, -9, -9, -9, -9, -9, -9, 10}), "......");
  EXPECT_EQ(decisions(92, {110, 70, 70, 120, 0, 0, 0, 0}), "....H.");
  EXPECT_EQ(decisions(93, {110, 70, 70, 120, 0, 0, 0, 0}), "....L.");
  EXPECT_EQ(decisions(95, {110, 70, 70, 120, 130, 60, 60, 140}), "....LH");
  EXPECT_EQ(decisions(0, {543137, -361329, -88834, -5508, -326594, 70438, -686188, 881252}), "..L...");
  EXPECT_EQ(decisions(0, {696149, -348164, 167182, 714964, 151066, 37670, -267038, 200067}), "......");
}

}  // namespace
}  // namespace scanknit
