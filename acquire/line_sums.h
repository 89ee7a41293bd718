// LineSums: a straight line through points, by least squares.
#pragma once

#include <algorithm>
#include <cmath>

namespace scanknit {

/// Least squares of y = at_zero + slope x. The results are only defined if variance() is > 0.
struct LineSums {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;

  void add(double at, double value) {
    n += 1;
    x += at;
    y += value;
    xx += at * at;
    xy += at * value;
    yy += value * value;
  }
  /// The variance of x.
  [[nodiscard]] double variance() const { return xx / n - x / n * (x / n); }
  [[nodiscard]] double slope() const { return (xy / n - x / n * (y / n)) / variance(); }
  [[nodiscard]] double at_zero() const { return y / n - slope() * (x / n); }
  /// The standard deviation of y from the line.
  [[nodiscard]] double residual() const {
    return std::sqrt(std::max(0.0, yy / n - y / n * (y / n) - slope() * slope() * variance()));
  }
};

}  // namespace scanknit
