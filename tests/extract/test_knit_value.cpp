// The bottleneck between two corners of a cube, against known answers and a dense grid that knows nothing of saddles.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <random>
#include <set>
#include <vector>

#include "extract/cell/knit_value.h"
#include "extract/cell/superlevel_components.h"
#include "extract/reference/knit_value_4d.h"
#include "tests/extract/trilinear_truth.h"

namespace scanknit {
namespace {

template <int N>
using Cube = std::array<double, std::size_t{1} << N>;

template <int N>
Cube<N> random_cube(std::mt19937& random, bool with_ties) {
  Cube<N> cube{};
  for (double& value : cube) value = with_ties ? double(random() % 7) - 3 : double(random()) / 2147483648.0 - 1;
  return cube;
}

template <int N>
double multilinear(const Cube<N>& cube, const std::array<double, N>& at) {
  double sum = 0;
  for (std::size_t corner = 0; corner < cube.size(); ++corner) {
    double weight = 1;
    for (std::size_t axis = 0; axis < N; ++axis) weight *= ((corner >> axis) & 1) != 0 ? at[axis] : 1 - at[axis];
    sum += weight * cube[corner];
  }
  return sum;
}

/// The bottlenecks of a grid of (n + 1)^N samples whose edges join neighbours along an axis: points enter from the
/// highest down, and two corners meet at the point that first connects them. Never above the truth.
template <int N>
class DenseGrid {
 public:
  static constexpr std::size_t kCubeCorners = std::size_t{1} << N;
  using Table = std::array<std::array<double, kCubeCorners>, kCubeCorners>;

  DenseGrid(const Cube<N>& cube, std::size_t n) : side_(n + 1) {
    std::size_t count = 1;
    for (std::size_t axis = 0; axis < N; ++axis) {
      stride_[axis] = count;
      count *= side_;
    }
    values_.resize(count);
    parent_.assign(count, kAbsent);
    for (std::size_t i = 0; i < count; ++i) {
      std::array<double, N> at{};
      for (std::size_t axis = 0; axis < N; ++axis) at[axis] = double(coordinate(i, axis)) / double(n);
      values_[i] = multilinear<N>(cube, at);
    }
    fill();
  }
  [[nodiscard]] double bottleneck(std::size_t a, std::size_t b) const { return table_[a][b]; }

 private:
  static constexpr std::size_t kAbsent = ~std::size_t{0};

  [[nodiscard]] std::size_t coordinate(std::size_t i, std::size_t axis) const { return i / stride_[axis] % side_; }
  [[nodiscard]] std::size_t corner(std::size_t c) const {
    std::size_t i = 0;
    for (std::size_t axis = 0; axis < N; ++axis) i += ((c >> axis) & 1) * (side_ - 1) * stride_[axis];
    return i;
  }
  std::size_t root(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void fill() {
    std::vector<std::size_t> order(values_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) { return values_[i] > values_[j]; });
    std::vector<std::array<std::size_t, 2>> apart;
    for (std::size_t a = 0; a < kCubeCorners; ++a) {
      for (std::size_t b = 0; b <= a; ++b) apart.push_back({a, b});
    }
    for (const std::size_t i : order) {
      parent_[i] = i;
      for (std::size_t axis = 0; axis < N; ++axis) {
        if (coordinate(i, axis) > 0) join(i, i - stride_[axis]);
        if (coordinate(i, axis) + 1 < side_) join(i, i + stride_[axis]);
      }
      std::erase_if(apart, [&](const auto& pair) {
        const std::size_t a = corner(pair[0]);
        const std::size_t b = corner(pair[1]);
        if (parent_[a] == kAbsent || parent_[b] == kAbsent || root(a) != root(b)) return false;
        table_[pair[0]][pair[1]] = table_[pair[1]][pair[0]] = values_[i];
        return true;
      });
      if (apart.empty()) return;
    }
  }
  void join(std::size_t i, std::size_t j) {
    if (parent_[j] != kAbsent) parent_[root(j)] = root(i);
  }

  std::size_t side_;
  std::array<std::size_t, N> stride_{};
  std::vector<double> values_;
  std::vector<std::size_t> parent_;
  Table table_{};
};

/// A path can be moved to the grid points of the cells it visits, by at most one step along each axis.
template <int N>
double grid_error_bound(const Cube<N>& cube, std::size_t n) {
  double sum = 0;
  for (std::size_t axis = 0; axis < N; ++axis) {
    double steepest = 0;
    for (std::size_t c = 0; c < cube.size(); ++c)
      steepest = std::max(steepest, std::abs(cube[c] - cube[c ^ (std::size_t{1} << axis)]));
    sum += steepest;
  }
  return sum / double(n);
}

constexpr double kRounding = 1e-13;  // a few hundred units in the last place of values of magnitude 1 to 3

template <int N>
void expect_agrees_with_dense_grid(const Cube<N>& cube, std::size_t n, double tolerance) {
  const DenseGrid<N> grid(cube, n);
  const double bound = grid_error_bound<N>(cube, n);
  for (std::size_t a = 0; a < cube.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      const double value = knit_value<N>(cube, static_cast<int>(a), static_cast<int>(b));
      ASSERT_GE(value, grid.bottleneck(a, b) - tolerance) << a << " " << b << " " << ::testing::PrintToString(cube);
      ASSERT_LE(value, grid.bottleneck(a, b) + bound + tolerance)
          << a << " " << b << " " << ::testing::PrintToString(cube);
    }
  }
}

Cube<3> above_each_other(const Cube<2>& bottom, const Cube<2>& top) {
  return {bottom[0], bottom[1], bottom[2], bottom[3], top[0], top[1], top[2], top[3]};
}

constexpr Cube<2> kFigure11{110, 70, 70, 120};

TEST(KnitValue, OfTheFaceOfFigure11IsItsSaddle) {
  EXPECT_DOUBLE_EQ(knit_value<2>(kFigure11, 0, 3), 830.0 / 9);
}

TEST(KnitValue, BesideAnEmptyCubeIsTheFaceSaddle) {
  EXPECT_DOUBLE_EQ(knit_value<3>(above_each_other(kFigure11, {0, 0, 0, 0}), 0, 3), 830.0 / 9);
}

TEST(KnitValue, MayBeTheSaddleOfTheOppositeFace) {
  EXPECT_DOUBLE_EQ(knit_value<3>(above_each_other(kFigure11, {130, 60, 60, 140}), 0, 3), 97 + 1.0 / 3);
}

TEST(KnitValue, MayBeABodySaddle) {
  EXPECT_NEAR(knit_value<3>(above_each_other(kFigure11, {60, 130, 130, 60}), 0, 3), 92.69767757, 5e-9);
}

TEST(KnitValue, IsTheLowerCornerWhenTheOppositeFaceIsHigher) {
  EXPECT_EQ(knit_value<3>(above_each_other(kFigure11, {140, 140, 140, 140}), 0, 3), 110);
}

TEST(KnitValue, OfACornerWithItselfIsItsValue) {
  EXPECT_EQ(knit_value<2>(kFigure11, 3, 3), 120);
  EXPECT_EQ(knit_value<3>(above_each_other(kFigure11, kFigure11), 7, 7), 120);
}

TEST(KnitValue, OfTwoCornersOfAFlatFaceIsTheirValue) {
  EXPECT_EQ(knit_value<2>({5, 5, 5, 5}, 0, 3), 5);
}

TEST(KnitValue, AgreesWithADenseGridOnRandomCubes) {
  std::mt19937 random(1);
  for (int i = 0; i < 250; ++i)
    expect_agrees_with_dense_grid<3>(random_cube<3>(random, false), i < 10 ? 48 : 20, kRounding);
}

TEST(KnitValue, AgreesWithADenseGridOnCubesWithTies) {
  std::mt19937 random(2);
  for (int i = 0; i < 250; ++i)
    expect_agrees_with_dense_grid<3>(random_cube<3>(random, true), i < 10 ? 48 : 20, kRounding);
}

/// A grid is close to the truth where the path must squeeze through a saddle: its error falls with the square of the
/// step, as the gradient vanishes there. Finer than the bound above can see.
TEST(KnitValue, AgreesWithADenseGridToSecondOrderAtBodySaddles) {
  constexpr std::size_t kSteps = 64;
  std::mt19937 random(3);
  int through_body = 0;
  while (through_body < 20) {
    const Cube<3> cube = random_cube<3>(random, false);
    const double value = knit_value<3>(cube, 0, 3);
    Cube<2> face{};
    std::copy_n(cube.begin(), 4, face.begin());
    const bool is_new = std::none_of(cube.begin(), cube.end(), [&](double corner) { return corner == value; }) &&
                        value > knit_value<2>(face, 0, 3) + 0.02;
    if (!is_new) continue;
    ++through_body;
    EXPECT_NEAR(value, DenseGrid<3>(cube, kSteps).bottleneck(0, 3), 16.0 / (kSteps * kSteps));
  }
}

std::size_t count_components(const Cube<3>& cube, double level) {
  const auto labels = superlevel_components(cube, level);
  std::set<std::int8_t> components(labels.begin(), labels.end());
  components.erase(kBelowLevel);
  return components.size();
}

TEST(SuperlevelComponents, AreAsManyAsInExactArithmetic) {
  std::mt19937 random(14);
  for (int i = 0; i < 100000; ++i) {
    const bool with_ties = i % 2 == 0;
    std::array<std::int64_t, 8> values{};
    for (std::int64_t& value : values)
      value = with_ties ? static_cast<std::int64_t>(random() % 7) - 3
                        : static_cast<std::int64_t>(random() >> 11) - (1 << 20);
    Cube<3> cube{};
    std::copy(values.begin(), values.end(), cube.begin());
    // The truth resolves ties as if all values were slightly larger. The next critical value is further than 1e-6 away.
    const double level = with_ties ? -1e-8 : 0;
    ASSERT_EQ(count_components(cube, level), static_cast<std::size_t>(test::trilinear_truth(values).high_regions))
        << ::testing::PrintToString(values);
  }
}

TEST(KnitValue, IsTheLevelWhereTheCornersPart) {
  std::mt19937 random(4);
  for (int i = 0; i < 20000; ++i) {
    const Cube<3> cube = random_cube<3>(random, i % 2 == 0);
    const double value = knit_value<3>(cube, 0, 3);
    const auto below = superlevel_components(cube, value - 1e-9);
    const auto above = superlevel_components(cube, value + 1e-9);
    ASSERT_EQ(below[0], below[3]) << ::testing::PrintToString(cube);
    ASSERT_TRUE(above[0] == kBelowLevel || above[0] != above[3]) << ::testing::PrintToString(cube);
  }
}

/// Corner i of the cube moved by one of its 48 symmetries.
unsigned moved_corner(unsigned i, const std::array<unsigned, 3>& axes, unsigned flips) {
  unsigned moved = flips;
  for (unsigned axis = 0; axis < 3; ++axis) moved ^= ((i >> axis) & 1) << axes[axis];
  return moved;
}

TEST(KnitValue, IsTheSameAfterThe48SymmetriesOfTheCube) {
  std::mt19937 random(5);
  for (int i = 0; i < 1000; ++i) {
    const Cube<3> cube = random_cube<3>(random, i % 2 == 0);
    const double value = knit_value<3>(cube, 0, 3);
    std::array<unsigned, 3> axes{0, 1, 2};
    do {
      for (unsigned flips = 0; flips < 8; ++flips) {
        Cube<3> moved{};
        for (unsigned c = 0; c < 8; ++c) moved[moved_corner(c, axes, flips)] = cube[c];
        const int a = static_cast<int>(moved_corner(0, axes, flips));
        const int b = static_cast<int>(moved_corner(3, axes, flips));
        ASSERT_NEAR(knit_value<3>(moved, a, b), value, kRounding) << ::testing::PrintToString(cube);
      }
    } while (std::next_permutation(axes.begin(), axes.end()));
  }
}

/// Cubes near to those whose body saddle degenerates to a curve, a plane or a monkey saddle.
TEST(KnitValue, IsStableNearDegenerateCubes) {
  std::mt19937 random(15);
  for (int i = 0; i < 20000; ++i) {
    const Cube<3> cube = random_cube<3>(random, true);
    const double noise = std::exp2(-10 - i % 40);
    Cube<3> moved = cube;
    for (double& value : moved) value += noise * (double(random()) / 2147483648.0 - 1);
    // No bottleneck moves further than the values do.
    ASSERT_NEAR(knit_value<3>(moved, 0, 3), knit_value<3>(cube, 0, 3), noise + kRounding)
        << ::testing::PrintToString(moved);
  }
}

TEST(KnitValue, DoesNotDependOnTheOrderOfTheCorners) {
  std::mt19937 random(6);
  for (int i = 0; i < 10000; ++i) {
    const Cube<3> cube = random_cube<3>(random, i % 2 == 0);
    ASSERT_EQ(knit_value<3>(cube, 5, 6), knit_value<3>(cube, 6, 5));
  }
}

TEST(KnitValue, IsNeverBelowTheFaceSaddle) {
  std::mt19937 random(7);
  for (int i = 0; i < 100000; ++i) {
    const Cube<3> cube = random_cube<3>(random, i % 2 == 0);
    Cube<2> face{};
    std::copy_n(cube.begin(), 4, face.begin());
    ASSERT_GE(knit_value<3>(cube, 1, 2), knit_value<2>(face, 1, 2));
  }
}

TEST(KnitValue, OfACubeConstantAlongZIsTheFaces) {
  std::mt19937 random(8);
  for (int i = 0; i < 10000; ++i) {
    const Cube<2> face = random_cube<2>(random, i % 2 == 0);
    const Cube<3> cube = above_each_other(face, face);
    ASSERT_NEAR(knit_value<3>(cube, 0, 3), knit_value<2>(face, 0, 3), kRounding);
    ASSERT_NEAR(knit_value<3>(cube, 1, 6), knit_value<2>(face, 1, 2), kRounding);
  }
}

TEST(KnitValue, OfASquareAgreesWithADenseGrid) {
  std::mt19937 random(9);
  for (int i = 0; i < 100; ++i) expect_agrees_with_dense_grid<2>(random_cube<2>(random, i % 2 == 0), 128, kRounding);
}

Cube<4> in_time(const Cube<3>& before, const Cube<3>& after) {
  Cube<4> cube{};
  std::copy(before.begin(), before.end(), cube.begin());
  std::copy(after.begin(), after.end(), cube.begin() + 8);
  return cube;
}

TEST(KnitValue4d, OfACubeConstantInTimeIsTheCubes) {
  std::mt19937 random(10);
  for (int i = 0; i < 20; ++i) {
    const Cube<3> cube = random_cube<3>(random, i % 2 == 0);
    const double value = knit_value<3>(cube, 0, 3);
    EXPECT_NEAR(knit_value<4>(in_time(cube, cube), 0, 3), value, kKnit4dTolerance * 6);
    EXPECT_NEAR(knit_value<4>(in_time(cube, cube), 0, 8 + 3), value, kKnit4dTolerance * 6);
  }
}

TEST(KnitValue4d, AgreesWithADenseGrid) {
  std::mt19937 random(11);
  for (int i = 0; i < 6; ++i)
    expect_agrees_with_dense_grid<4>(random_cube<4>(random, i % 2 == 0), 12, kKnit4dTolerance * 6);
}

/// With two High columns among Lows, a path crosses from one to the other at a single moment.
TEST(KnitValue4d, IsTheBestMomentWhenOnlyTwoColumnsAreHigh) {
  std::mt19937 random(12);
  for (int i = 0; i < 12; ++i) {
    Cube<4> cube{};
    for (std::size_t c = 0; c < 16; ++c) {
      const bool is_high_column = c % 8 == 0 || c % 8 == 3;
      cube[c] = double(random()) / 4294967296.0 + (is_high_column ? 2 : -4);
    }
    double best = -4;
    for (int moment = 0; moment <= 4096; ++moment) {
      Cube<3> slice{};
      for (std::size_t c = 0; c < 8; ++c) slice[c] = cube[c] + (cube[c + 8] - cube[c]) * moment / 4096;
      best = std::max(best, knit_value<3>(slice, 0, 3));
    }
    EXPECT_NEAR(knit_value<4>(cube, 0, 8 + 3), best, kKnit4dTolerance * 8);
  }
}

TEST(KnitValue4d, BoundsAreAsTightAsAskedAndOrdered) {
  std::mt19937 random(13);
  const Cube<4> cube = random_cube<4>(random, false);
  KnitBounds wide;
  for (const double tolerance : {1e-2, 1e-4, 1e-6}) {
    const KnitBounds bounds = knit_bounds_4d(cube, 0, 6, tolerance);
    EXPECT_LE(bounds.upper - bounds.lower, tolerance);
    EXPECT_LE(bounds.lower, bounds.upper);
    if (tolerance < 1e-2) {
      EXPECT_LE(wide.lower, bounds.upper);
      EXPECT_LE(bounds.lower, wide.upper);
    }
    wide = bounds;
  }
}

TEST(KnitValue4d, OfAConstantIsTheConstant) {
  Cube<4> cube{};
  cube.fill(3);
  EXPECT_EQ(knit_value<4>(cube, 0, 15), 3);
}

}  // namespace
}  // namespace scanknit
