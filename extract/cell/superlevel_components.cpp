#include "extract/cell/superlevel_components.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

namespace scanknit {
namespace {

/// Four columns of the cube, c = x + 2y, relative to the level: `low` at z = 0, `high` at z = 1.
struct Columns {
  std::array<double, 4> low{};
  std::array<double, 4> high{};

  [[nodiscard]] double at(std::size_t c, double z) const { return (1 - z) * low[c] + z * high[c]; }
};

/// Representatives of the slices between two events, and the cube's own two ends: at most 9.
class SlicePlaces {
 public:
  explicit SlicePlaces(const Columns& columns) {
    std::array<double, 8> events{0, 1};  // sorted
    std::size_t count = 2;
    const auto add = [&](double z) {
      if (!(z > 0 && z < 1)) return;  // also the NaN and infinity of a vanishing leading coefficient
      auto* const place = std::upper_bound(events.data(), events.data() + count, z);
      std::move_backward(place, events.data() + count, events.data() + count + 1);
      *place = z;
      ++count;
    };
    for (std::size_t c = 0; c < 4; ++c) add(columns.low[c] / (columns.low[c] - columns.high[c]));
    add_saddle_events(columns, add);
    for (std::size_t i = 0; i + 1 < count; ++i) places_[size_++] = events[i] + (events[i + 1] - events[i]) / 2;
    places_[size_++] = 1;
  }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] double operator[](std::size_t i) const { return places_[i]; }

 private:
  /// The roots of A C - B D, the numerator of the slice's saddle value.
  template <typename Add>
  static void add_saddle_events(const Columns& columns, const Add& add) {
    const auto& v = columns.low;
    std::array<double, 4> slope{};
    for (std::size_t c = 0; c < 4; ++c) slope[c] = columns.high[c] - v[c];
    const double constant = v[0] * v[3] - v[1] * v[2];
    const double linear = (v[0] * slope[3] + slope[0] * v[3]) - (v[1] * slope[2] + slope[1] * v[2]);
    const double quadratic = slope[0] * slope[3] - slope[1] * slope[2];
    const double discriminant = linear * linear - 4 * quadratic * constant;
    if (!(discriminant >= 0)) return;
    const double q = -(linear + std::copysign(std::sqrt(discriminant), linear)) / 2;
    add(q / quadratic);
    add(constant / q);
  }

  std::array<double, 9> places_{0};
  std::size_t size_ = 1;
};

/// Union-find over the corners of all slices.
class SliceCorners {
 public:
  SliceCorners() { std::iota(parent_.begin(), parent_.end(), std::uint8_t{0}); }
  [[nodiscard]] std::uint8_t root(std::size_t i) const {
    while (parent_[i] != i) i = parent_[i];
    return static_cast<std::uint8_t>(i);
  }
  void join(std::size_t i, std::size_t j) { parent_[root(i)] = root(j); }

 private:
  std::array<std::uint8_t, 36> parent_{};
};

constexpr std::array<std::array<std::size_t, 2>, 4> kSliceEdges{{{0, 1}, {2, 3}, {0, 2}, {1, 3}}};

}  // namespace

std::array<std::int8_t, 8> superlevel_components(const std::array<double, 8>& corner_values, double level) {
  Columns columns;
  for (std::size_t c = 0; c < 4; ++c) {
    columns.low[c] = corner_values[c] - level;
    columns.high[c] = corner_values[c + 4] - level;
  }
  const SlicePlaces places(columns);
  SliceCorners corners;
  std::array<bool, 4> is_high_before{};
  for (std::size_t slice = 0; slice < places.size(); ++slice) {
    std::array<double, 4> v{};
    std::array<bool, 4> is_high{};
    for (std::size_t c = 0; c < 4; ++c) {
      v[c] = columns.at(c, places[slice]);
      is_high[c] = v[c] >= 0;
      if (is_high[c] && is_high_before[c]) corners.join(4 * slice + c, 4 * (slice - 1) + c);
    }
    for (const auto& [a, b] : kSliceEdges) {
      if (is_high[a] && is_high[b]) corners.join(4 * slice + a, 4 * slice + b);
    }
    const double determinant = v[0] * v[3] - v[1] * v[2];
    if (is_high[0] && is_high[3] && determinant >= 0) corners.join(4 * slice, 4 * slice + 3);
    if (is_high[1] && is_high[2] && determinant <= 0) corners.join(4 * slice + 1, 4 * slice + 2);
    is_high_before = is_high;
  }
  std::array<std::int8_t, 8> labels{};
  for (std::size_t i = 0; i < 8; ++i) {
    const std::size_t node = i < 4 ? i : 4 * (places.size() - 1) + i - 4;
    labels[i] = corner_values[i] >= level ? static_cast<std::int8_t>(corners.root(node)) : kBelowLevel;
  }
  return labels;
}

}  // namespace scanknit
