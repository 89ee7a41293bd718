// `trilinear` is exact: cell by cell and over whole volumes the mesh has the topology of the trilinear isosurface, as
// the independent truth (trilinear_truth.h) tells it, ties included.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <numeric>
#include <random>
#include <set>
#include <sstream>
#include <string>

#include "extract/resolve_cell.h"
#include "tests/core/temporary_folder.h"
#include "tests/extract/trilinear_truth.h"
#include "tests/extract/volumes.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using test::Box;
using test::CellTruth;
using test::VolumeTruth;
using IntegerCell = std::array<std::int64_t, kCorners>;

/// The truth's numbers, of triangles.
struct CellSurface {
  int components = 0;
  int euler = 0;
  int contours = 0;
  std::array<int, kEdges> edge_component{};  ///< numbered as they first appear; -1: no triangle there
};

class UnionFind {
 public:
  UnionFind() { std::iota(parent_.begin(), parent_.end(), std::size_t{0}); }
  std::size_t root(std::size_t i) const {
    while (parent_[i] != i) i = parent_[i];
    return i;
  }
  void join(std::size_t i, std::size_t j) { parent_[root(i)] = root(j); }

 private:
  std::array<std::size_t, kEdges + CellTriangles::kMaxInterior> parent_{};
};

CellSurface surface_of(std::span<const CellTriangle> triangles) {
  constexpr std::size_t kVertices = kEdges + CellTriangles::kMaxInterior;
  std::array<std::array<bool, kVertices>, kVertices> runs{};  // an edge of a triangle, one way
  std::array<bool, kVertices> used{};
  UnionFind parts;
  for (const CellTriangle& t : triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      used[t[i]] = true;
      runs[t[i]][t[(i + 1) % 3]] = true;
      parts.join(t[i], t[(i + 1) % 3]);
    }
  }
  CellSurface surface;
  surface.euler = static_cast<int>(triangles.size());
  UnionFind boundary;
  std::array<bool, kVertices> on_boundary{};
  for (std::size_t a = 0; a < kVertices; ++a) {
    surface.euler += used[a] ? 1 : 0;
    surface.components += used[a] && parts.root(a) == a ? 1 : 0;
    for (std::size_t b = 0; b < kVertices; ++b) {
      surface.euler -= a < b && (runs[a][b] || runs[b][a]) ? 1 : 0;
      if (runs[a][b] == runs[b][a]) continue;
      boundary.join(a, b);
      on_boundary[a] = on_boundary[b] = true;
    }
  }
  for (std::size_t a = 0; a < kVertices; ++a) surface.contours += on_boundary[a] && boundary.root(a) == a ? 1 : 0;
  std::array<int, kVertices> number{};
  number.fill(-1);
  int numbered = 0;
  for (std::size_t edge = 0; edge < kEdges; ++edge) {
    surface.edge_component[edge] = -1;
    if (!used[edge]) continue;
    int& component = number[parts.root(edge)];
    if (component < 0) component = numbered++;
    surface.edge_component[edge] = component;
  }
  return surface;
}

CornerMask highs_of(const IntegerCell& cell) {
  unsigned highs = 0;
  for (std::size_t i = 0; i < kCorners; ++i) highs |= cell[i] >= 0 ? 1u << i : 0u;
  return static_cast<CornerMask>(highs);
}

CellSurface trilinear_surface(const IntegerCell& cell) {
  std::array<float, kCorners> samples{};
  for (std::size_t i = 0; i < kCorners; ++i) samples[4 * (i & 1) + (i & 2) + (i >> 2)] = static_cast<float>(cell[i]);
  ValueBlock values;
  values.show(samples.data(), 4, 2);
  const CellEntry entry = resolve_cell(values, 0, 0, 0, highs_of(cell), 0, Decider::kTrilinear);
  return surface_of(CellTable::get().triangles(entry));
}

/// Small ranges are full of ties; in the largest every integer is still a float.
constexpr std::array<std::int64_t, 6> kMagnitudes{1, 2, 4, 16, 1000, 1 << 20};

IntegerCell random_cell(std::mt19937& random, std::int64_t magnitude) {
  IntegerCell cell{};
  for (std::int64_t& value : cell) value = static_cast<std::int64_t>(random() % (2 * magnitude + 1)) - magnitude;
  return cell;
}

void expect_true_cells(int cells, unsigned seed) {
  std::mt19937 random(seed);
  int wrong = 0;
  for (int i = 0; i < cells && wrong < 10; ++i) {
    const IntegerCell cell = random_cell(random, kMagnitudes[static_cast<std::size_t>(i) % kMagnitudes.size()]);
    const CellTruth truth = test::trilinear_truth(cell);
    const CellSurface surface = trilinear_surface(cell);
    const bool is_true = surface.components == truth.components && surface.euler == truth.euler &&
                         surface.contours == truth.contours && surface.edge_component == truth.edge_component;
    EXPECT_TRUE(is_true) << ::testing::PrintToString(cell) << ": components " << surface.components << " not "
                         << truth.components << ", Euler " << surface.euler << " not " << truth.euler << ", contours "
                         << surface.contours << " not " << truth.contours << " (cell " << i << ", seed " << seed << ')';
    wrong += is_true ? 0 : 1;
  }
}

TEST(Topology, OfRandomCellsIsTheTruth) {
  expect_true_cells(20000, 1);
}

TEST(Topology, OfEveryCellOfThreeLevelsIsTheTruth) {  // -1, 0 and 1: 6,561 cells, most of them ties
  for (int number = 0; number < 6561; ++number) {
    IntegerCell cell{};
    int rest = number;
    for (std::int64_t& value : cell) {
      value = rest % 3 - 1;
      rest /= 3;
    }
    const CellTruth truth = test::trilinear_truth(cell);
    const CellSurface surface = trilinear_surface(cell);
    ASSERT_EQ(surface.euler, truth.euler) << ::testing::PrintToString(cell);
    ASSERT_EQ(surface.edge_component, truth.edge_component) << ::testing::PrintToString(cell);
  }
}

TEST(Long, TopologyOfAMillionRandomCellsIsTheTruth) {
  if (std::getenv("SCANKNIT_LONG_TESTS") == nullptr)
    GTEST_SKIP() << "SKIPPED: set SCANKNIT_LONG_TESTS=1 to run it (some ten seconds)";
  expect_true_cells(1'000'000, 2);
}

Box box_of(const IntegerCell& cell) {
  Box box({2, 2, 2});
  std::transform(cell.begin(), cell.end(), box.samples.begin(), [](std::int64_t v) { return static_cast<float>(v); });
  return box;
}

TEST(Topology, OfAVolumeOfOneCellIsTheTruth) {
  std::mt19937 random(3);
  for (int i = 0; i < 2000; ++i) {
    const IntegerCell cell = random_cell(random, kMagnitudes[static_cast<std::size_t>(i) % kMagnitudes.size()]);
    const CellTruth truth = test::trilinear_truth(cell);
    const MeshCheck check = check_mesh(test::extract(box_of(cell)).mesh);
    ASSERT_EQ(check.components, static_cast<std::size_t>(truth.components)) << ::testing::PrintToString(cell);
    ASSERT_EQ(check.euler, truth.euler) << ::testing::PrintToString(cell);
  }
}

/// Random values of one kind, the same as floats and as the truth's integers.
struct IntegerVolume {
  std::array<int, 3> dims{};  ///< x slowest, as the truth has it
  std::vector<std::int64_t> values;

  template <typename Value>
  IntegerVolume(std::mt19937& random, const Value& value) {
    for (int& size : dims) size = 12 + static_cast<int>(random() % 9);
    for (int x = 0; x < dims[0]; ++x) {
      for (int y = 0; y < dims[1]; ++y) {
        for (int z = 0; z < dims[2]; ++z) values.push_back(value(x, y, z));
      }
    }
  }
  [[nodiscard]] Surface extract() const {
    Box box({dims[2], dims[1], dims[0]});
    std::transform(values.begin(), values.end(), box.samples.begin(),
                   [](std::int64_t v) { return v == test::kUnobserved ? test::kNaN : static_cast<float>(v); });
    return test::extract(box);
  }
};

void expect_true(const IntegerVolume& volume) {
  const VolumeTruth truth = test::trilinear_truth(volume.values, volume.dims);
  const MeshCheck check = check_mesh(volume.extract().mesh);
  test::expect_manifold(check);
  EXPECT_EQ(check.components, static_cast<std::size_t>(truth.components));
  EXPECT_EQ(check.euler, truth.euler);
}

class VolumeTopology : public ::testing::TestWithParam<unsigned> {};
INSTANTIATE_TEST_SUITE_P(Seeds, VolumeTopology, ::testing::Range(1u, 7u));

TEST_P(VolumeTopology, OfWhiteNoiseIsTheTruth) {
  std::mt19937 random(GetParam());
  expect_true({random, [&](int, int, int) { return static_cast<std::int64_t>(random() % 2000001) - 1000000; }});
}

TEST_P(VolumeTopology, OfNoiseOfFewLevelsIsTheTruth) {
  std::mt19937 random(GetParam());
  const unsigned levels = 2 + GetParam() % 4;
  expect_true({random, [&](int, int, int) { return static_cast<std::int64_t>(random() % levels) - 1; }});
}

TEST_P(VolumeTopology, OfASmoothFieldIsTheTruth) {
  std::mt19937 random(GetParam());
  std::uniform_real_distribution<double> uniform(-1.3, 1.3);
  std::array<std::array<double, 4>, 6> waves;
  for (auto& wave : waves) std::generate(wave.begin(), wave.end(), [&] { return uniform(random); });
  expect_true({random, [&](int x, int y, int z) {
                 double sum = 0;
                 for (const auto& [a, b, c, phase] : waves) sum += std::cos(a * x + b * y + c * z + 3 * phase);
                 return std::llround(1e5 * sum);
               }});
}

TEST_P(VolumeTopology, OfAQuantisedSmoothFieldIsTheTruth) {
  std::mt19937 random(GetParam());
  expect_true({random, [&](int x, int y, int z) {
                 const double phase = GetParam();
                 return std::llround(2 * std::cos(0.9 * x + phase) * std::cos(1.1 * y) + std::cos(1.3 * z - phase));
               }});
}

TEST_P(VolumeTopology, OfNoiseWithHolesIsTheTruth) {
  std::mt19937 random(GetParam());
  const unsigned one_in = 3 + 9 * (GetParam() % 3);
  expect_true({random, [&](int, int, int) {
                 const auto value = static_cast<std::int64_t>(random() % 7) - 3;
                 return random() % one_in == 0 ? test::kUnobserved : value;
               }});
}

TEST(Topology, TunnelsLowerTheEulerCharacteristicByTwo) {
  const test::Box box(test::white_noise(24, 5));
  ExtractConfig faces_only;
  faces_only.decider = Decider::kAsymptotic;
  const Surface exact = test::extract(box);
  ASSERT_GT(exact.cases.tunnels, 20u);
  EXPECT_EQ(check_mesh(exact.mesh).euler,
            check_mesh(test::extract(box, faces_only).mesh).euler - 2 * static_cast<long long>(exact.cases.tunnels));
}

TEST(Topology, HasTheEulerCharacteristicsOfThePublishedCells) {
  if (!fs::exists(test::published_cells())) GTEST_SKIP() << "SKIPPED: no cells at " << test::published_cells();
  const test::TemporaryFolder folder;
  ASSERT_TRUE(test::unpack_published_cells(folder.path()));
  int cells = 0;
  int right = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder / "Grids")) {
    const test::PublishedCell cell = test::read_published_cell(entry.path());
    Box box({2, 2, 2});
    std::copy(cell.values.begin(), cell.values.end(), box.samples.begin());
    const MeshCheck check = check_mesh(test::extract(box).mesh);
    ++cells;
    right += check.euler == cell.euler && check.non_manifold_edges == 0 ? 1 : 0;
    EXPECT_EQ(check.euler, cell.euler) << entry.path().filename();
  }
  EXPECT_EQ(cells, 10000);
  EXPECT_EQ(right, 10000);
}

}  // namespace
}  // namespace scanknit
