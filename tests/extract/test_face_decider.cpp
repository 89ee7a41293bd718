#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <string>

#include "extract/cell.h"
#include "extract/face_decider.h"

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

TEST(FaceDecider, ChordsOfOppositeEdgesAgree) {
  // The value where the chords between the crossings of opposite edges meet; a line meets the bilinear conic at most
  // twice, so it decides every strict case alike.
  std::mt19937 random(13);
  std::uniform_real_distribution<double> uniform(0.01, 1);
  for (int i = 0; i < 100000; ++i) {
    const double a = uniform(random);   // (0, 0)
    const double b = -uniform(random);  // (1, 0)
    const double c = uniform(random);   // (1, 1)
    const double d = -uniform(random);  // (0, 1)
    const double bottom = a / (a - b);  // s at t = 0
    const double top = d / (d - c);     // s at t = 1
    const double left = a / (a - d);    // t at s = 0
    const double right = b / (b - c);   // t at s = 1
    // s = bottom + (top - bottom) t and t = left + (right - left) s
    const double s = (bottom + (top - bottom) * left) / (1 - (top - bottom) * (right - left));
    const double t = left + (right - left) * s;
    const double value = (1 - s) * (1 - t) * a + s * (1 - t) * b + s * t * c + (1 - s) * t * d;
    constexpr double kRounding = 1e-12;  // of values up to 1
    if (std::abs(value) < kRounding) continue;
    ASSERT_EQ(decide_face({a, b, c, d}), value > 0 ? kHighsJoined : kHighsSeparated);
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
