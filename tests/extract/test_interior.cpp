// The interior test by itself: known tunnels, ties, and independence of the axes.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <random>
#include <set>

#include "extract/cell/contours.h"
#include "extract/cell/cube_symmetry.h"
#include "extract/cell/face_decider.h"
#include "extract/cell/interior_test.h"
#include "tests/extract/trilinear_truth.h"

namespace scanknit {
namespace {

CornerMask highs_of(const CellValues& values) {
  unsigned highs = 0;
  for (std::size_t i = 0; i < kCorners; ++i) highs |= values[i] >= 0 ? 1u << i : 0u;
  return static_cast<CornerMask>(highs);
}

FaceMask joined_faces_of(const CellValues& values) {
  unsigned joined = 0;
  for (std::size_t face = 0; face < kFaces; ++face) {
    FaceValues value;
    for (std::size_t i = 0; i < 4; ++i) value[i] = values[static_cast<std::size_t>(kFaceRing[face][i])];
    joined |= decide_face(value) == FaceDecision::kHighsJoined ? 1u << face : 0u;
  }
  return static_cast<FaceMask>(joined);
}

std::optional<Tunnel> tunnel_of(const CellValues& values) {
  return find_tunnel(values, highs_of(values), joined_faces_of(values));
}

/// The crossed edges of the contour through `edge`.
unsigned contour_through(const CellValues& values, EdgeIndex edge) {
  const Contours contours = trace_contours(highs_of(values), joined_faces_of(values));
  for (std::size_t i = 0; i < contours.count; ++i) {
    unsigned edges = 0;
    for (const EdgeIndex e : contours[i]) edges |= 1u << e;
    if (((edges >> edge) & 1) != 0) return edges;
  }
  return 0;
}

/// Signed powers of two and near them, with up to `octaves` between the least and the greatest.
CellValues random_wide_cell(std::mt19937& random, int octaves) {
  CellValues values;
  for (double& value : values) {
    const double mantissa = random() % 2 == 0 ? 1.0 : 1.0 + static_cast<double>(random() % 16) / 16;
    value = std::ldexp(random() % 2 == 0 ? mantissa : -mantissa, static_cast<int>(random() % unsigned(octaves)) + 4);
  }
  return values;
}

CellValues random_cell(std::mt19937& random, int magnitude) {
  CellValues values;
  for (double& value : values)
    value = static_cast<double>(static_cast<int>(random() % static_cast<unsigned>(2 * magnitude + 1)) - magnitude);
  return values;
}

TEST(Interior, OppositeHighsFarAboveTheirLowsAreJoined) {
  EXPECT_TRUE(tunnel_of({10, -1, -1, -1, -1, -1, -1, 10}));
}

TEST(Interior, OppositeHighsNotFarEnoughAboveAreNot) {
  EXPECT_FALSE(tunnel_of({10, -9, -9, -9, -9, -9, -9, 10}));
}

TEST(Interior, OppositeLowsFarBelowTheirHighsAreJoined) {
  EXPECT_TRUE(tunnel_of({-10, 1, 1, 1, 1, 1, 1, -10}));
}

TEST(Interior, TunnelBesideAnAmbiguousFace) {
  EXPECT_TRUE(tunnel_of({543137, -361329, -88834, -5508, -326594, 70438, -686188, 881252}));
}

TEST(Interior, HighsJoinedOnAFaceAlreadyNeedNoTunnel) {
  EXPECT_FALSE(tunnel_of({15, -25, -25, 25, 35, -35, -35, 45}));
}

// On the diagonal from corner 0 to corner 7 the function is c (1 - 3t + 3t^2) - 3 (t - t^2) = c - 3 (c + 1) (t - t^2):
// lowest at t = 1/2, (c - 3)/4. The body saddles lie there.
TEST(Interior, TieOfTheBodySaddleJoinsTheHighs) {
  EXPECT_TRUE(tunnel_of({3, -1, -1, -1, -1, -1, -1, 3}));
  EXPECT_FALSE(tunnel_of({2.999999, -1, -1, -1, -1, -1, -1, 2.999999}));
  EXPECT_FALSE(tunnel_of({-3, 1, 1, 1, 1, 1, 1, -3}));
  EXPECT_TRUE(tunnel_of({-3.000001, 1, 1, 1, 1, 1, 1, -3.000001}));
}

TEST(Interior, RimsLieOnDifferentContours) {
  std::mt19937 random(1);
  int tunnels = 0;
  for (int i = 0; i < 200000; ++i) {
    const CellValues values = random_cell(random, i % 2 == 0 ? 5 : 1 << 20);
    const auto tunnel = tunnel_of(values);
    if (!tunnel) continue;
    ++tunnels;
    ASSERT_TRUE(is_crossed(highs_of(values), tunnel->rim_a));
    ASSERT_TRUE(is_crossed(highs_of(values), tunnel->rim_b));
    ASSERT_NE(contour_through(values, tunnel->rim_a), contour_through(values, tunnel->rim_b))
        << ::testing::PrintToString(values);
  }
  EXPECT_GT(tunnels, 500);  // some 0.5 % of random cells
}

class InteriorTruth : public ::testing::TestWithParam<CellValues (*)(std::mt19937&)> {};
INSTANTIATE_TEST_SUITE_P(Cells, InteriorTruth,
                         ::testing::Values([](std::mt19937& random) { return random_cell(random, 3); },
                                           [](std::mt19937& random) { return random_cell(random, 1000); },
                                           [](std::mt19937& random) { return random_wide_cell(random, 6); },
                                           [](std::mt19937& random) { return random_wide_cell(random, 24); }));

TEST_P(InteriorTruth, TunnelIsWhereTheTruthHasOne) {
  std::mt19937 random(2);
  int tunnels = 0;
  for (int i = 0; i < 50000; ++i) {
    const CellValues values = GetParam()(random);
    std::array<std::int64_t, kCorners> integers;
    std::transform(values.begin(), values.end(), integers.begin(), [](double v) { return std::int64_t(v); });
    const test::CellTruth truth = test::trilinear_truth(integers);
    const bool has_tunnel = truth.euler != truth.components;
    ASSERT_EQ(tunnel_of(values).has_value(), has_tunnel) << ::testing::PrintToString(values);
    if (!has_tunnel) continue;
    ++tunnels;
    ASSERT_TRUE(kMayHaveTunnel[highs_of(values)]);
  }
  EXPECT_GT(tunnels, 50);
}

TEST(Interior, TunnelTurnsWithTheCell) {
  std::mt19937 random(3);
  int tunnels = 0;
  for (int i = 0; i < 20000; ++i) {
    const CellValues values = i % 3 == 0   ? random_cell(random, 4)
                              : i % 3 == 1 ? random_cell(random, 1000)
                                           : random_wide_cell(random, 200);  // far beyond a double's 53 bits
    const auto tunnel = tunnel_of(values);
    tunnels += tunnel ? 1 : 0;
    for (const CubeSymmetry& rotation : kRotations) {
      for (const bool mirrored : {false, true}) {
        const CubeSymmetry symmetry = mirrored ? compose(kMirrorX, rotation) : rotation;
        CellValues moved;
        for (std::size_t c = 0; c < kCorners; ++c) moved[symmetry.corner[c]] = values[c];
        const auto found = tunnel_of(moved);
        ASSERT_EQ(found.has_value(), tunnel.has_value()) << ::testing::PrintToString(values);
        if (!tunnel) continue;
        const std::set<unsigned> rims{contour_through(moved, symmetry.edge[tunnel->rim_a]),
                                      contour_through(moved, symmetry.edge[tunnel->rim_b])};
        const std::set<unsigned> found_rims{contour_through(moved, found->rim_a), contour_through(moved, found->rim_b)};
        ASSERT_EQ(found_rims, rims) << ::testing::PrintToString(values);
      }
    }
  }
  EXPECT_GT(tunnels, 50);
}

// Samples of cos cos cos at multiples of pi / 2 and the like: what should be zero is the rounding of pi.
TEST(Interior, RoundingDecidesNothing) {
  EXPECT_TRUE(tunnel_of({1, -2.44929371e-16, -0.5, -0.5, -0.5, 6.12323426e-17, 6.12323426e-17, 0.5}));
  for (const CellValues& values :
       {CellValues{1, 1.22464685e-16, -0.5, 6.12323426e-17, 0.707106769, -0.5, 1, -1.83697015e-16},
        CellValues{1362.84692, 1.15216281e-07, -30746786, 3.2848515e-09, 0.44511956, -7418096, 11767904,
                   -1.94298089e-09}}) {
    const auto tunnel = tunnel_of(values);
    if (!tunnel) continue;
    EXPECT_NE(contour_through(values, tunnel->rim_a), contour_through(values, tunnel->rim_b));
  }
}

TEST(Interior, TunnelDoesNotDependOnTheScale) {
  std::mt19937 random(4);
  for (int i = 0; i < 20000; ++i) {
    const CellValues values = random_cell(random, 6);
    for (const double scale : {0x1p-60, 0x1p+60}) {
      CellValues scaled;
      std::transform(values.begin(), values.end(), scaled.begin(), [&](double v) { return scale * v; });
      ASSERT_EQ(tunnel_of(scaled).has_value(), tunnel_of(values).has_value()) << ::testing::PrintToString(values);
    }
  }
}

}  // namespace
}  // namespace scanknit
