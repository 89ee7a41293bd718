#include "extract/reference/knit_value_4d.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/check.h"
#include "extract/cell/superlevel_components.h"

namespace scanknit {
namespace {

using Cube = std::array<double, 8>;
using Labels = std::array<std::int8_t, 8>;

Cube cube_at(const std::array<double, 16>& v, double w) {
  Cube cube{};
  for (std::size_t i = 0; i < 8; ++i) cube[i] = (1 - w) * v[i] + w * v[i + 8];
  return cube;
}

/// Is everything joined in `inner` joined in `outer`? A corner is joined with itself when it reaches the level.
bool is_within(const Labels& inner, const Labels& outer) {
  for (std::size_t i = 0; i < 8; ++i) {
    if (inner[i] == kBelowLevel) continue;
    if (outer[i] == kBelowLevel) return false;
    for (std::size_t j = 0; j < i; ++j) {
      if (inner[j] == inner[i] && outer[j] != outer[i]) return false;
    }
  }
  return true;
}

/// The corners of all intervals of w, joined where the lower cubes join them.
class Sweep {
 public:
  Sweep(const std::array<double, 16>& corner_values, double level, double slack)
      : values_(corner_values), level_(level), slack_(slack) {
    run(0, cube_at(values_, 0), 1, cube_at(values_, 1));
  }

  [[nodiscard]] bool are_joined(int corner_a, int corner_b) const {
    return root(node(corner_a)) == root(node(corner_b));
  }

 private:
  void run(double w0, const Cube& start, double w1, const Cube& end) {
    Cube lower{};
    Cube upper{};
    double variation = 0;
    for (std::size_t i = 0; i < 8; ++i) {
      lower[i] = std::min(start[i], end[i]);
      upper[i] = std::max(start[i], end[i]);
      variation = std::max(variation, upper[i] - lower[i]);
    }
    const Labels joined = superlevel_components(lower, level_ - slack_);
    // Within 2 slack {upper >= level + slack} lies in {lower >= level - slack}: decided whatever rounding says.
    if (variation <= 2 * slack_ || is_within(superlevel_components(upper, level_ + slack_), joined)) {
      append(joined);
      return;
    }
    const double middle = (w0 + w1) / 2;
    const Cube cube = cube_at(values_, middle);
    run(w0, start, middle, cube);
    run(middle, cube, w1, end);
  }

  /// The next interval. A corner that reaches the level in it and in the one before does so where they meet.
  void append(const Labels& joined) {
    const std::size_t first = parent_.size();
    for (std::size_t i = 0; i < 8; ++i) parent_.push_back(first + i);
    for (std::size_t i = 0; i < 8; ++i) {
      if (joined[i] == kBelowLevel) continue;
      if (first > 0 && before_[i] != kBelowLevel) join(first + i, first + i - 8);
      for (std::size_t j = 0; j < i; ++j) {
        if (joined[j] == joined[i]) join(first + i, first + j);
      }
    }
    before_ = joined;
  }

  [[nodiscard]] std::size_t node(int corner) const {
    const auto i = static_cast<std::size_t>(corner);
    return i < 8 ? i : parent_.size() - 16 + i;
  }
  [[nodiscard]] std::size_t root(std::size_t i) const {
    while (parent_[i] != i) i = parent_[i];
    return i;
  }
  void join(std::size_t i, std::size_t j) {
    const std::size_t a = root(i);
    const std::size_t b = root(j);
    parent_[std::max(a, b)] = std::min(a, b);
    parent_[i] = std::min(a, b);  // keeps the chains along w short
  }

  const std::array<double, 16>& values_;
  double level_;
  double slack_;
  std::vector<std::size_t> parent_;
  Labels before_{};
};

double range_of(const std::array<double, 16>& values) {
  const auto [least, greatest] = std::minmax_element(values.begin(), values.end());
  return *greatest - *least;
}

}  // namespace

KnitBounds knit_bounds_4d(const std::array<double, 16>& corner_values, int corner_a, int corner_b, double tolerance) {
  SCANKNIT_CHECK(corner_a >= 0 && corner_a < 16 && corner_b >= 0 && corner_b < 16);
  SCANKNIT_CHECK(tolerance > 0 && tolerance >= 1e-12 * range_of(corner_values));
  KnitBounds bounds;
  bounds.lower = *std::min_element(corner_values.begin(), corner_values.end());
  bounds.upper =
      std::min(corner_values[static_cast<std::size_t>(corner_a)], corner_values[static_cast<std::size_t>(corner_b)]);
  while (bounds.upper - bounds.lower > tolerance) {
    const double level = bounds.lower + (bounds.upper - bounds.lower) / 2;
    const double slack = (bounds.upper - bounds.lower) / 8;
    if (Sweep(corner_values, level, slack).are_joined(corner_a, corner_b)) {
      bounds.lower = level - slack;
    } else {
      bounds.upper = level + slack;
    }
  }
  return bounds;
}

template <>
double knit_value<4>(const std::array<double, 16>& corner_values, int corner_a, int corner_b) {
  const double range = range_of(corner_values);
  if (!(range > 0)) return corner_values[0];
  const KnitBounds bounds = knit_bounds_4d(corner_values, corner_a, corner_b, kKnit4dTolerance * range);
  return bounds.lower + (bounds.upper - bounds.lower) / 2;
}

}  // namespace scanknit
