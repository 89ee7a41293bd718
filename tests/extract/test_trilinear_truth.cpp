// The truth must itself be true: known cells, published invariants, symmetry, surfaces of known topology.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <functional>
#include <iostream>
#include <map>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "tests/core/temporary_folder.h"
#include "tests/extract/trilinear_truth.h"
#include "tests/support/places.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;
using Values = std::array<std::int64_t, kCorners>;

struct KnownCell {
  const char* name;
  std::int64_t isovalue;
  Values values;
  int components, euler, high_regions, low_regions;
  const char* faces;
  std::array<int, kEdges> edges;  ///< same number: same component
};

std::ostream& operator<<(std::ostream& out, const KnownCell& cell) {
  return out << cell.name;
}

class TrilinearTruthOfKnownCell : public ::testing::TestWithParam<KnownCell> {};

TEST_P(TrilinearTruthOfKnownCell, IsAsPublished) {
  const KnownCell& known = GetParam();
  Values values = known.values;
  for (std::int64_t& value : values) value -= known.isovalue;
  const CellTruth truth = trilinear_truth(values);
  EXPECT_EQ(truth.components, known.components);
  EXPECT_EQ(truth.euler, known.euler);
  EXPECT_EQ(truth.high_regions, known.high_regions);
  EXPECT_EQ(truth.low_regions, known.low_regions);
  EXPECT_EQ(std::string(truth.faces.begin(), truth.faces.end()), known.faces);
  EXPECT_EQ(truth.edge_component, known.edges);
}

INSTANTIATE_TEST_SUITE_P(Vectors, TrilinearTruthOfKnownCell,
                         ::testing::Values(KnownCell{"corners_apart",
                                                     0,
                                                     {10, -9, -9, -9, -9, -9, -9, 10},
                                                     2,
                                                     2,
                                                     2,
                                                     1,
                                                     "......",
                                                     {0, -1, -1, 1, 0, -1, -1, 1, 0, -1, -1, 1}},
                                           KnownCell{"tunnel_between_corners",
                                                     0,
                                                     {10, -1, -1, -1, -1, -1, -1, 10},
                                                     1,
                                                     0,
                                                     1,
                                                     1,
                                                     "......",
                                                     {0, -1, -1, 0, 0, -1, -1, 0, 0, -1, -1, 0}},
                                           KnownCell{"below_face_saddle",
                                                     92,
                                                     {110, 70, 70, 120, 0, 0, 0, 0},
                                                     1,
                                                     1,
                                                     1,
                                                     1,
                                                     "....H.",
                                                     {0, 0, -1, -1, 0, 0, -1, -1, 0, -1, -1, 0}},
                                           KnownCell{"above_face_saddle",
                                                     93,
                                                     {110, 70, 70, 120, 0, 0, 0, 0},
                                                     2,
                                                     2,
                                                     2,
                                                     1,
                                                     "....L.",
                                                     {0, 1, -1, -1, 0, 1, -1, -1, 0, -1, -1, 1}},
                                           KnownCell{"joined_through_the_other_face",
                                                     95,
                                                     {110, 70, 70, 120, 130, 60, 60, 140},
                                                     1,
                                                     1,
                                                     1,
                                                     1,
                                                     "....LH",
                                                     {0, 0, 0, 0, 0, 0, 0, 0, -1, -1, -1, -1}},
                                           KnownCell{"tunnel_with_an_ambiguous_face",
                                                     0,
                                                     {543137, -361329, -88834, -5508, -326594, 70438, -686188, 881252},
                                                     1,
                                                     0,
                                                     1,
                                                     1,
                                                     "..L...",
                                                     {0, -1, 0, 0, 0, -1, -1, -1, 0, 0, -1, 0}},
                                           KnownCell{"two_lows",
                                                     0,
                                                     {696149, -348164, 167182, 714964, 151066, 37670, -267038, 200067},
                                                     2,
                                                     2,
                                                     1,
                                                     2,
                                                     "......",
                                                     {0, -1, -1, 1, -1, 0, 1, -1, -1, 0, 1, -1}}),
                         [](const auto& test) { return std::string(test.param.name); });

Values random_values(std::mt19937& random, std::int64_t magnitude) {
  Values values{};
  for (std::int64_t& value : values) value = std::uniform_int_distribution(-magnitude, magnitude)(random);
  return values;
}

/// Within five standard deviations of two samples of that size.
void expect_like(int count, int known) {
  EXPECT_NEAR(count, known, 5 * std::sqrt(2.0 * known));
}

TEST(TrilinearTruth, HasTheKnownHistogramOverRandomCells) {
  std::mt19937 random(1);
  std::map<std::pair<int, int>, int> histogram;  // (components, Euler characteristic)
  for (int i = 0; i < 200000; ++i) {
    const CellTruth truth = trilinear_truth(random_values(random, 1 << 20));
    ++histogram[{truth.components, truth.euler}];
  }
  expect_like(histogram[{0, 0}], 1615);
  expect_like(histogram[{1, 1}], 137846);
  expect_like(histogram[{1, 0}], 1070);
  expect_like(histogram[{2, 2}], 55498);
  expect_like(histogram[{2, 1}], 19);
  expect_like(histogram[{3, 3}], 3586);
  expect_like(histogram[{4, 4}], 365);
  EXPECT_EQ(histogram.size(), 7u);
}

/// Corner i of the cell moved by one of its 48 symmetries.
int moved_corner(int i, const std::array<int, 3>& axes, int flips) {
  int moved = flips;
  for (int axis = 0; axis < 3; ++axis) moved ^= corner_coordinate(i, axis) << axes[static_cast<std::size_t>(axis)];
  return moved;
}

/// Component numbers by first appearance, in the order of `edges`.
std::array<int, kEdges> renumbered(const CellTruth& truth, const std::array<int, kEdges>& edges) {
  std::map<int, int> number{{-1, -1}};
  std::array<int, kEdges> components{};
  for (std::size_t e = 0; e < kEdges; ++e) {
    const int component = truth.edge_component[static_cast<std::size_t>(edges[e])];
    components[e] = number.try_emplace(component, static_cast<int>(number.size()) - 1).first->second;
  }
  return components;
}

/// Among others, of the sweep's direction.
void expect_independent_of_axes(const Values& values) {
  const CellTruth truth = trilinear_truth(values);
  std::array<int, 3> axes{0, 1, 2};
  do {
    for (int flips = 0; flips < 8; ++flips) {
      Values moved{};
      for (int c = 0; c < kCorners; ++c)
        moved[static_cast<std::size_t>(moved_corner(c, axes, flips))] = values[static_cast<std::size_t>(c)];
      std::array<int, kEdges> moved_edges{};
      for (int e = 0; e < kEdges; ++e)
        moved_edges[static_cast<std::size_t>(e)] =
            edge_between(moved_corner(edge_low_corner(e), axes, flips), moved_corner(edge_high_corner(e), axes, flips));
      const CellTruth other = trilinear_truth(moved);
      ASSERT_EQ(other.high_regions, truth.high_regions) << ::testing::PrintToString(values);
      ASSERT_EQ(other.low_regions, truth.low_regions) << ::testing::PrintToString(values);
      ASSERT_EQ(other.euler, truth.euler) << ::testing::PrintToString(values);
      ASSERT_EQ(renumbered(other, moved_edges), truth.edge_component) << ::testing::PrintToString(values);
    }
  } while (std::next_permutation(axes.begin(), axes.end()));
}

TEST(TrilinearTruth, IsTheSameAfterThe48SymmetriesOfTheCell) {
  std::mt19937 random(2);
  for (int i = 0; i < 2000; ++i) expect_independent_of_axes(random_values(random, 1 << 20));
}

TEST(TrilinearTruth, IsTheSameAfterThe48SymmetriesOfACellWithTies) {
  std::mt19937 random(3);
  for (int i = 0; i < 2000; ++i) expect_independent_of_axes(random_values(random, 2));
}

TEST(TrilinearTruth, ResolvesTiesLikeASmallIncreaseOfAllValues) {
  // K v + 1: a threshold at -1/K is nearer to 0 than any other critical value of cells of so small integers.
  constexpr std::int64_t kScale = std::int64_t{1} << 27;
  std::mt19937 random(4);
  for (int i = 0; i < 50000; ++i) {
    const Values values = random_values(random, 3);
    Values increased{};
    std::transform(values.begin(), values.end(), increased.begin(), [](std::int64_t v) { return kScale * v + 1; });
    const CellTruth truth = trilinear_truth(values);
    const CellTruth expected = trilinear_truth(increased);
    ASSERT_EQ(truth.components, expected.components) << ::testing::PrintToString(values);
    ASSERT_EQ(truth.euler, expected.euler) << ::testing::PrintToString(values);
    ASSERT_EQ(truth.edge_component, expected.edge_component) << ::testing::PrintToString(values);
    ASSERT_EQ(truth.faces, expected.faces) << ::testing::PrintToString(values);
  }
}

TEST(TrilinearTruth, NegationSwapsHighAndLow) {
  std::mt19937 random(5);
  for (int i = 0; i < 20000; ++i) {
    const Values values = random_values(random, 1 << 28);  // so wide that no tie occurs
    Values negated{};
    std::transform(values.begin(), values.end(), negated.begin(), std::negate<>());
    const CellTruth truth = trilinear_truth(values);
    const CellTruth other = trilinear_truth(negated);
    ASSERT_EQ(other.high_regions, truth.low_regions) << ::testing::PrintToString(values);
    ASSERT_EQ(other.low_regions, truth.high_regions) << ::testing::PrintToString(values);
    ASSERT_EQ(other.edge_component, truth.edge_component) << ::testing::PrintToString(values);
  }
}

fs::path published_cells() {
  return data_folder() / "mc33_single_cells" / "MarchingCubes_cases.tar.xz";
}

/// int32 nx ny nz, float bounding box[6], float values[8], little-endian; x fastest.
std::array<float, kCorners> read_cell(const fs::path& path) {
  constexpr std::size_t kHeaderBytes = 36;
  const std::string bytes = read_text(path);
  std::array<float, kCorners> values{};
  if (bytes.size() == kHeaderBytes + sizeof values)
    std::memcpy(values.data(), bytes.data() + kHeaderBytes, sizeof values);
  else
    ADD_FAILURE() << path << ": " << bytes.size() << " bytes";
  return values;
}

struct IntegerCell {
  Values values{};
  bool is_exact = true;
};

/// Scaled by a power of two as far as the truth allows. The few cells whose values span more bits are rounded there.
IntegerCell to_integers(const std::array<float, kCorners>& values) {
  double largest = 0;
  for (const float value : values) largest = std::max(largest, std::abs(double{value}));
  const double scale = std::exp2(std::floor(std::log2(double(kLargestTruthValue) / largest)));
  IntegerCell cell;
  for (std::size_t i = 0; i < kCorners; ++i) {
    const double scaled = scale * double{values[i]};
    cell.values[i] = std::llround(scaled);
    cell.is_exact = cell.is_exact && double(cell.values[i]) == scaled;
  }
  return cell;
}

/// L. Custodio, T. Etiene, S. Pesco, C. Silva, Practical considerations on marching cubes 33 topological correctness,
/// Computers & Graphics 2013, supplement.
TEST(TrilinearTruth, HasTheEulerCharacteristicsOfThePublishedCells) {
  if (!fs::exists(published_cells())) GTEST_SKIP() << "SKIPPED: no cells at " << published_cells();
  const TemporaryFolder folder;
  const std::string unpack = "tar -xf '" + published_cells().string() + "' -C '" + folder.path().string() +
                             "' --strip-components=1 --wildcards '*.iso' '*-euler_number.txt'";
  ASSERT_EQ(std::system(unpack.c_str()), 0) << unpack;
  int cells = 0;
  int rounded = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder / "Grids")) {
    const std::string name = entry.path().filename().string();
    const std::string number = name.substr(0, name.find('-'));
    std::istringstream answer(read_text(folder / "Grid_invariants" / (number + "-euler_number.txt")));
    int euler = -1000;
    answer >> euler;
    const IntegerCell cell = to_integers(read_cell(entry.path()));
    EXPECT_EQ(trilinear_truth(cell.values).euler, euler) << name;
    ++cells;
    rounded += cell.is_exact ? 0 : 1;
  }
  EXPECT_EQ(cells, 10000);
  std::cout << cells << " cells, " << rounded << " of them rounded to " << kLargestTruthValue << " steps\n";
}

struct Volume {
  std::array<int, 3> dims;
  std::vector<std::int64_t> values;

  explicit Volume(const std::array<int, 3>& size)
      : dims(size), values(static_cast<std::size_t>(size[0] * size[1] * size[2])) {}
  std::int64_t& at(int x, int y, int z) { return values[static_cast<std::size_t>((x * dims[1] + y) * dims[2] + z)]; }
  [[nodiscard]] VolumeTruth truth() const { return trilinear_truth(values, dims); }
};

Volume sampled(int side, const std::function<std::int64_t(std::int64_t, std::int64_t, std::int64_t)>& f) {
  Volume volume({side, side, side});
  for (int x = 0; x < side; ++x) {
    for (int y = 0; y < side; ++y) {
      for (int z = 0; z < side; ++z) volume.at(x, y, z) = f(x, y, z);
    }
  }
  return volume;
}

std::int64_t ball(std::int64_t x, std::int64_t y, std::int64_t z, std::int64_t centre) {
  const auto square = [&](std::int64_t v) { return (v - centre) * (v - centre); };
  return 14 - square(x) - square(y) - square(z);
}

TEST(VolumeTruth, OfASphereIsOneComponentWithEuler2) {
  const VolumeTruth truth = sampled(11, [](auto x, auto y, auto z) { return ball(x, y, z, 5); }).truth();
  EXPECT_EQ(truth.components, 1);
  EXPECT_EQ(truth.euler, 2);
}

TEST(VolumeTruth, OfTwoSpheresIsTwoComponentsWithEuler4) {
  const auto spheres = [](auto x, auto y, auto z) { return std::max(ball(x, y, z, 5), ball(x, y, z, 14)); };
  const VolumeTruth truth = sampled(20, spheres).truth();
  EXPECT_EQ(truth.components, 2);
  EXPECT_EQ(truth.euler, 4);
}

TEST(VolumeTruth, OfATorusHasEuler0) {
  const auto torus = [](std::int64_t x, std::int64_t y, std::int64_t z) -> std::int64_t {
    const std::int64_t from_axis = (x - 10) * (x - 10) + (y - 10) * (y - 10);
    const std::int64_t sum = from_axis + (z - 10) * (z - 10) + 36 - 9;  // radii 6 and 3
    return 4 * 36 * from_axis - sum * sum;
  };
  const VolumeTruth truth = sampled(21, torus).truth();
  EXPECT_EQ(truth.components, 1);
  EXPECT_EQ(truth.euler, 0);
}

TEST(VolumeTruth, OfASphereCutByTheBorderIsADisc) {
  const VolumeTruth truth = sampled(11, [](auto x, auto y, auto z) { return ball(x, y, z + 5, 5); }).truth();
  EXPECT_EQ(truth.components, 1);
  EXPECT_EQ(truth.euler, 1);
}

TEST(VolumeTruth, OfASphereWithAnUnobservedSampleHasAHole) {
  Volume volume = sampled(11, [](auto x, auto y, auto z) { return ball(x, y, z, 5); });
  volume.at(5, 5, 9) = kUnobserved;  // next to the sphere's top, at about 8.7
  const VolumeTruth truth = volume.truth();
  EXPECT_EQ(truth.components, 1);
  EXPECT_EQ(truth.euler, 1);
}

TEST(VolumeTruth, OfAClosedSurfaceHasEvenEuler) {
  std::mt19937 random(6);
  for (int i = 0; i < 20; ++i) {
    Volume volume({9, 9, 9});
    std::fill(volume.values.begin(), volume.values.end(), -1);
    for (int x = 1; x < 8; ++x) {
      for (int y = 1; y < 8; ++y) {
        for (int z = 1; z < 8; ++z) volume.at(x, y, z) = static_cast<std::int64_t>(random() % 5) - 2;
      }
    }
    EXPECT_EQ(volume.truth().euler % 2, 0);
  }
}

TEST(VolumeTruth, OfASingleCellIsTheCells) {
  std::mt19937 random(7);
  for (int i = 0; i < 5000; ++i) {
    const Values values = random_values(random, i % 2 == 0 ? 2 : 1 << 20);
    Volume volume({2, 2, 2});
    for (int c = 0; c < kCorners; ++c) volume.at(c & 1, (c >> 1) & 1, c >> 2) = values[static_cast<std::size_t>(c)];
    const CellTruth cell = trilinear_truth(values);
    ASSERT_EQ(volume.truth().components, cell.components);
    ASSERT_EQ(volume.truth().euler, cell.euler);
  }
}

TEST(VolumeTruth, SplitsASurfaceThatSkippedCellsPinch) {
  Volume volume({3, 3, 2});
  for (int x = 0; x < 3; ++x) {
    for (int y = 0; y < 3; ++y) {
      volume.at(x, y, 0) = 1;
      volume.at(x, y, 1) = -1;
    }
  }
  volume.at(2, 0, 0) = kUnobserved;  // leaves two cells that share the edge in the middle
  volume.at(0, 2, 0) = kUnobserved;
  const VolumeTruth truth = volume.truth();
  EXPECT_EQ(truth.vertices, 8);
  EXPECT_EQ(truth.components, 2);
  EXPECT_EQ(truth.euler, 2);
}

}  // namespace
}  // namespace scanknit::test
