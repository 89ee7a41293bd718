// What each decider promises, and how they differ.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "extract/cell/knit_value.h"
#include "extract/resolve_cell.h"
#include "tests/extract/volumes.h"

namespace scanknit {
namespace {

using test::Box;
using test::Dense;

struct NamedDecider {
  const char* name;
  Decider decider;
  bool is_tetrahedral = false;  ///< cuts faces its own way: other boundary edges
};

std::ostream& operator<<(std::ostream& out, const NamedDecider& named) {
  return out << named.name;
}

ExtractConfig config_of(Decider decider, double isovalue = 0) {
  ExtractConfig config;
  config.decider = decider;
  config.isovalue = isovalue;
  return config;
}

class SoundDecider : public ::testing::TestWithParam<NamedDecider> {
 protected:
  static void expect_sound(const Dense& volume, double isovalue = 0) {
    const MeshCheck check = check_mesh(test::extract(Box(volume), config_of(GetParam().decider, isovalue)).mesh);
    EXPECT_GT(check.triangles, 0u);
    test::expect_manifold(check);
    if (!GetParam().is_tetrahedral) {
      EXPECT_EQ(check.boundary_edges, test::expected_boundary_edges(volume, static_cast<float>(isovalue)));
    }
  }
};

INSTANTIATE_TEST_SUITE_P(
    Deciders, SoundDecider,
    ::testing::Values(NamedDecider{"trilinear", Decider::kTrilinear}, NamedDecider{"asymptotic", Decider::kAsymptotic},
                      NamedDecider{"chord", Decider::kChord}, NamedDecider{"knit", Decider::kKnit},
                      NamedDecider{"fixed_high", Decider::kFixedHigh}, NamedDecider{"fixed_low", Decider::kFixedLow},
                      NamedDecider{"tetra5", Decider::kTetra5, true}, NamedDecider{"tetra6", Decider::kTetra6, true},
                      NamedDecider{"tetra24", Decider::kTetra24, true}),
    [](const auto& test) { return std::string(test.param.name); });

constexpr int kSide = 20;

TEST_P(SoundDecider, OnWhiteNoise) {
  for (const unsigned seed : {1u, 2u, 3u}) expect_sound(test::white_noise(kSide, seed));
}

TEST_P(SoundDecider, OnASmoothField) {
  expect_sound(test::dense_from(kSide, [](double x, double y, double z) {
    return std::cos(0.7 * x + 0.3 * z) + std::cos(0.9 * y - 0.4 * x) + std::cos(0.8 * z + 0.5 * y);
  }));
}

TEST_P(SoundDecider, OnNoiseOfThreeLevels) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    expect_sound(test::three_level_noise(kSide, seed));
    expect_sound(test::three_level_noise(kSide, seed), 1);
  }
}

TEST_P(SoundDecider, OnNoiseWithHoles) {
  for (const unsigned one_in : {50u, 6u, 3u}) {
    Dense volume = test::white_noise(kSide, one_in);
    test::punch_holes(volume, one_in, 7);
    expect_sound(volume);
  }
}

TEST_P(SoundDecider, OnTiesWithHolesThatPinch) {
  for (const unsigned one_in : {20u, 5u, 3u}) {
    Dense volume = test::three_level_noise(kSide, one_in);
    test::punch_holes(volume, one_in, 8);
    expect_sound(volume);
  }
}

TEST_P(SoundDecider, GivesTheSameBitsEveryTime) {
  const Box box(test::white_noise(kSide, 9));
  const ExtractConfig config = config_of(GetParam().decider);
  test::expect_same_bits(test::extract(box, config).mesh, test::extract(box, config).mesh);
}

/// Cells of a 9^3 volume resolved one by one.
class Cells {
 public:
  Cells() {
    values_.show_buffer();
    for (int x = kBlockFirst; x <= kBlockLast; ++x) {
      for (int y = kBlockFirst; y <= kBlockLast; ++y) {
        const auto row = values_.row(x, y);
        std::fill(row.begin(), row.end(), kUnobserved);
      }
    }
  }
  /// Coordinates -1 to 9; what is not set is unobserved.
  [[nodiscard]] float& at(int x, int y, int z) { return values_.row(x, y)[static_cast<std::size_t>(z - kBlockFirst)]; }
  void fill(std::mt19937& random, const Eigen::Vector3i& first, const Eigen::Vector3i& last) {
    for (int x = first.x(); x <= last.x(); ++x) {
      for (int y = first.y(); y <= last.y(); ++y) {
        for (int z = first.z(); z <= last.z(); ++z) at(x, y, z) = static_cast<float>(random() % 2001) - 1000.0f;
      }
    }
  }
  [[nodiscard]] std::array<double, kCorners> corners(const Eigen::Vector3i& cell) const {
    std::array<double, kCorners> corners{};
    for (int i = 0; i < kCorners; ++i) {
      const Eigen::Vector3i corner(corner_coordinate(i, 0), corner_coordinate(i, 1), corner_coordinate(i, 2));
      corners[static_cast<std::size_t>(i)] = static_cast<double>(values_.at(cell + corner));
    }
    return corners;
  }
  [[nodiscard]] CornerMask highs(const Eigen::Vector3i& cell, double isovalue) const {
    const auto values = corners(cell);
    unsigned highs = 0;
    for (std::size_t i = 0; i < kCorners; ++i) highs |= values[i] >= isovalue ? 1u << i : 0u;
    return static_cast<CornerMask>(highs);
  }
  [[nodiscard]] CellEntry resolve(const Eigen::Vector3i& cell, double isovalue, Decider decider) const {
    return resolve_cell(values_, cell.x(), cell.y(), cell.z(), highs(cell, isovalue), isovalue, decider);
  }
  [[nodiscard]] bool joins(const Eigen::Vector3i& cell, std::size_t face, double isovalue, Decider decider) const {
    return ((CellTable::get().joined_faces(resolve(cell, isovalue, decider)) >> face) & 1) != 0;
  }

 private:
  ValueBlock values_;
};

/// The two Highs of an ambiguous face.
std::array<int, 2> diagonal_highs(CornerMask highs, std::size_t face) {
  const auto& c = kFaceCorners[face];
  return is_high(highs, c[0]) ? std::array{c[0], c[2]} : std::array{c[1], c[3]};
}

TEST(Deciders, TrilinearDiffersFromAsymptoticInTunnelsOnly) {
  std::mt19937 random(1);
  const CellTable& table = CellTable::get();
  int tunnels = 0;
  for (int i = 0; i < 100000; ++i) {
    Cells cells;
    cells.fill(random, {0, 0, 0}, {1, 1, 1});
    const CellEntry faces_only = cells.resolve({0, 0, 0}, 0, Decider::kAsymptotic);
    const CellEntry exact = cells.resolve({0, 0, 0}, 0, Decider::kTrilinear);
    ASSERT_FALSE(table.has_tunnel(faces_only));
    ASSERT_EQ(exact != faces_only, table.has_tunnel(exact));
    ASSERT_EQ(table.highs(exact), table.highs(faces_only));
    ASSERT_EQ(table.joined_faces(exact), table.joined_faces(faces_only));
    tunnels += table.has_tunnel(exact) ? 1 : 0;
  }
  EXPECT_GT(tunnels, 100);
}

TEST(Deciders, ChordAndAsymptoticMakeTheSameMesh) {
  for (const Dense& volume : {test::white_noise(24, 2), test::three_level_noise(24, 2)}) {
    const Mesh chord = test::extract(Box(volume), config_of(Decider::kChord)).mesh;
    test::expect_same_bits(chord, test::extract(Box(volume), config_of(Decider::kAsymptotic)).mesh);
  }
}

TEST(Deciders, FixedOnesJoinAllAmbiguousFacesOrNone) {
  const Box box(test::white_noise(16, 3));
  const CaseCounts high = test::extract(box, config_of(Decider::kFixedHigh)).cases;
  const CaseCounts low = test::extract(box, config_of(Decider::kFixedLow)).cases;
  EXPECT_GT(high.ambiguous_faces_joined, 0u);
  EXPECT_EQ(high.ambiguous_faces_separated, 0u);
  EXPECT_EQ(low.ambiguous_faces_joined, 0u);
  EXPECT_EQ(low.ambiguous_faces_separated, high.ambiguous_faces_joined);
}

TEST(Deciders, OnlyTrilinearMakesTunnels) {
  const Box box(test::white_noise(20, 4));
  EXPECT_GT(test::extract(box).cases.tunnels, 0u);
  for (const Decider decider :
       {Decider::kAsymptotic, Decider::kChord, Decider::kKnit, Decider::kFixedHigh, Decider::kFixedLow})
    EXPECT_EQ(test::extract(box, config_of(decider)).cases.tunnels, 0u);
}

/// The face 110 70 70 120 with the opposite corners of the one cell there is.
Box knit_example(const std::array<float, 4>& opposite) {
  Box box({2, 2, 2});
  box.samples = {110, 70, 70, 120, opposite[0], opposite[1], opposite[2], opposite[3]};
  return box;
}
constexpr std::size_t kExampleFace = 4;  // -z

bool knit_joins_example(const std::array<float, 4>& opposite, double isovalue, Decider decider) {
  const Box box = knit_example(opposite);
  Cells cells;
  for (int i = 0; i < kCorners; ++i) cells.at(i & 1, (i >> 1) & 1, i >> 2) = box.samples[static_cast<std::size_t>(i)];
  return cells.joins({0, 0, 0}, kExampleFace, isovalue, decider);
}

TEST(Knit, JoinsUpToTheKnownLevelsAndNotAbove) {
  const auto expect_level = [](const std::array<float, 4>& opposite, double level) {
    constexpr double kAside = 1e-7;
    EXPECT_TRUE(knit_joins_example(opposite, level - kAside, Decider::kKnit)) << level;
    EXPECT_FALSE(knit_joins_example(opposite, level + kAside, Decider::kKnit)) << level;
  };
  expect_level({0, 0, 0, 0}, 830.0 / 9);
  expect_level({130, 60, 60, 140}, 97 + 1.0 / 3);
  expect_level({60, 130, 130, 60}, 92.69767757);
  // With 140 all round the level is the lower High, 110: every isovalue that leaves the face ambiguous joins.
  EXPECT_TRUE(knit_joins_example({140, 140, 140, 140}, 110, Decider::kKnit));
}

TEST(Knit, JoinsThroughTheOtherEndOfTheCellWhereTrilinearSeparates) {
  EXPECT_TRUE(knit_joins_example({130, 60, 60, 140}, 95, Decider::kKnit));
  EXPECT_FALSE(knit_joins_example({130, 60, 60, 140}, 95, Decider::kTrilinear));
  const Box box = knit_example({130, 60, 60, 140});
  const MeshCheck knit = check_mesh(test::extract(box, config_of(Decider::kKnit, 95)).mesh);
  EXPECT_EQ(knit.components, 2u);  // one round each of the two columns of Lows
  EXPECT_EQ(knit.euler, 2);
  const MeshCheck trilinear = check_mesh(test::extract(box, config_of(Decider::kTrilinear, 95)).mesh);
  EXPECT_EQ(trilinear.components, 1u);
  EXPECT_EQ(trilinear.euler, 1);
}

TEST(Knit, IsTheLargerOfBothCellsKnitValuesAndBothCellsAgree) {
  std::mt19937 random(5);
  int faces = 0;
  int joined_by_one_only = 0;
  for (int i = 0; i < 6000; ++i) {
    const int axis = i % 3;
    const Eigen::Vector3i step = Eigen::Vector3i::Unit(axis);
    const Eigen::Vector3i lower = Eigen::Vector3i::Constant(i % 2 == 0 ? 0 : 6);  // at both ends of the block
    const Eigen::Vector3i upper = lower + step;
    Cells cells;
    cells.fill(random, lower, upper + Eigen::Vector3i::Ones());
    const auto face = static_cast<std::size_t>(2 * axis);  // of the upper cell
    const CornerMask highs = cells.highs(upper, 0);
    if (((kAmbiguousFaces[highs] >> face) & 1) == 0) continue;
    const auto [a, b] = diagonal_highs(highs, face);
    const double in_upper = knit_value<3>(cells.corners(upper), a, b);
    const double in_lower = knit_value<3>(cells.corners(lower), a | (1 << axis), b | (1 << axis));
    const bool joins = 0 <= std::max(in_upper, in_lower);
    ASSERT_EQ(cells.joins(upper, face, 0, Decider::kKnit), joins) << in_upper << ' ' << in_lower;
    ASSERT_EQ(cells.joins(lower, face + 1, 0, Decider::kKnit), joins) << in_upper << ' ' << in_lower;
    ++faces;
    joined_by_one_only += (in_upper < 0) != (in_lower < 0) ? 1 : 0;
  }
  EXPECT_GT(faces, 500);
  EXPECT_GT(joined_by_one_only, 10);
}

TEST(Knit, OfABorderFaceIsTheOneCells) {
  std::mt19937 random(6);
  int faces = 0;
  for (int i = 0; i < 5000; ++i) {
    Cells cells;
    cells.fill(random, {0, 0, 0}, {1, 1, 1});
    if (i % 2 == 0) {  // half the neighbour is there: not enough
      cells.at(2, 0, 0) = cells.at(-1, 0, 1) = cells.at(0, 2, 1) = cells.at(0, -1, 0) = 1000;
    }
    const CornerMask highs = cells.highs({0, 0, 0}, 0);
    for (unsigned left = kAmbiguousFaces[highs]; left != 0; left &= left - 1) {
      const auto face = static_cast<std::size_t>(std::countr_zero(left));
      const auto [a, b] = diagonal_highs(highs, face);
      ASSERT_EQ(cells.joins({0, 0, 0}, face, 0, Decider::kKnit), 0 <= knit_value<3>(cells.corners({0, 0, 0}), a, b));
      ++faces;
    }
  }
  EXPECT_GT(faces, 1000);
}

TEST(Knit, JoinsWhateverTheFaceAloneWouldJoin) {
  const Box box(test::white_noise(20, 7));
  const CaseCounts knit = test::extract(box, config_of(Decider::kKnit)).cases;
  const CaseCounts face = test::extract(box, config_of(Decider::kAsymptotic)).cases;
  EXPECT_GT(knit.ambiguous_faces_joined, face.ambiguous_faces_joined);
  std::mt19937 random(8);
  for (int i = 0; i < 5000; ++i) {
    Cells cells;
    cells.fill(random, {-1, -1, -1}, {2, 2, 2});
    const CellTable& table = CellTable::get();
    const FaceMask by_face = table.joined_faces(cells.resolve({0, 0, 0}, 0, Decider::kAsymptotic));
    const FaceMask by_knit = table.joined_faces(cells.resolve({0, 0, 0}, 0, Decider::kKnit));
    ASSERT_EQ(by_face & ~by_knit, 0);
  }
}

/// Two Highs diagonal on the face that both cells share: configuration 6 at x = 1 to 2, and at x = 0 to 1 the
/// complement of configuration 3.
Box lorensen_example() {
  Box box({3, 2, 2}, 1);
  for (const auto& [i, j, k] : {std::array{1, 1, 0}, {1, 0, 1}, {2, 1, 0}, {2, 0, 1}, {2, 1, 1}}) box.at(i, j, k) = -1;
  return box;
}

/// Boundary edges of the mesh in the plane i = 1, inside the volume.
std::size_t boundary_edges_in_the_middle(const Mesh& mesh) {
  std::set<std::array<std::uint32_t, 2>> sides;
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) sides.insert({t[i], t[(i + 1) % 3]});
  }
  std::size_t count = 0;
  for (const auto& [a, b] : sides) {
    const bool is_in_the_middle = mesh.positions_m[a].x() == 1 && mesh.positions_m[b].x() == 1;
    count += is_in_the_middle && sides.count({b, a}) == 0 ? 1 : 0;
  }
  return count;
}

TEST(Lorensen, LeavesAHoleWhereACaseMeetsAComplement) {
  const Surface surface = test::extract(lorensen_example(), config_of(Decider::kLorensen));
  EXPECT_EQ(surface.cases.of_configuration(6), 1u);
  EXPECT_EQ(surface.cases.of_configuration(3), 1u);
  EXPECT_EQ(boundary_edges_in_the_middle(surface.mesh), 4u);
}

TEST(Lorensen, HoleIsNotThereForTheOtherDeciders) {
  for (const Decider decider : {Decider::kTrilinear, Decider::kAsymptotic, Decider::kChord, Decider::kKnit,
                                Decider::kFixedHigh, Decider::kFixedLow})
    EXPECT_EQ(boundary_edges_in_the_middle(test::extract(lorensen_example(), config_of(decider)).mesh), 0u);
}

TEST(Lorensen, OnNoiseHasHolesAndNoOtherFault) {
  const Dense noise = test::white_noise(kSide, 10);
  const MeshCheck check = check_mesh(test::extract(Box(noise), config_of(Decider::kLorensen)).mesh);
  EXPECT_TRUE(check.is_well_formed);
  EXPECT_EQ(check.non_manifold_edges, 0u);
  EXPECT_EQ(check.misoriented_edges, 0u);
  EXPECT_EQ(check.duplicate_triangles, 0u);
  EXPECT_GT(check.boundary_edges, test::expected_boundary_edges(noise, 0));
}

TEST(Lorensen, PrintsNothing) {
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  const Surface surface = test::extract(lorensen_example(), config_of(Decider::kLorensen));
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  EXPECT_FALSE(surface.mesh.empty());
}

}  // namespace
}  // namespace scanknit
