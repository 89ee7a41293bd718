#include "fusion/align/point_grid.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/check.h"

namespace scanknit {

PointGrid::PointGrid(std::span<const Eigen::Vector3f> points, float radius) : points_(points), radius_(radius) {
  SCANKNIT_CHECK(radius > 0);
  Eigen::Vector3f high = Eigen::Vector3f::Zero();
  if (!points.empty()) low_ = high = points[0];
  for (const Eigen::Vector3f& p : points) {
    low_ = low_.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  constexpr float kMostCubes = 2'000'000;  // along an axis: 21 bits of a key
  radius_ = std::max(radius_, (high - low_).maxCoeff() / kMostCubes);
  for (int axis = 0; axis < 3; ++axis) {
    cubes_[static_cast<std::size_t>(axis)] = static_cast<std::int64_t>((high - low_)[axis] / radius_) + 3;
  }
  std::vector<std::pair<std::uint64_t, std::uint32_t>> sorted(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    sorted[i] = {key_of(cube_of(points[i])), static_cast<std::uint32_t>(i)};
  std::sort(sorted.begin(), sorted.end());
  std::size_t slots = 2;
  shift_ = 63;
  while (slots < 2 * sorted.size() + 2) {
    slots *= 2;
    --shift_;
  }
  slots_.resize(slots);
  order_.resize(sorted.size());
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    const auto [key, index] = sorted[i];
    order_[i] = index;
    std::size_t at = place_of(key);
    while (slots_[at].key != kEmpty && slots_[at].key != key) at = (at + 1) & (slots - 1);
    if (slots_[at].key == kEmpty) slots_[at] = {key, static_cast<std::uint32_t>(i), 0};
    ++slots_[at].count;
  }
}

std::array<std::int64_t, 3> PointGrid::cube_of(const Eigen::Vector3f& p) const {
  std::array<std::int64_t, 3> cube;
  for (int axis = 0; axis < 3; ++axis) {
    const auto k = static_cast<std::size_t>(axis);
    const float along = std::floor((p[axis] - low_[axis]) / radius_);
    if (!(along >= -1) || !(along < static_cast<float>(cubes_[k]))) return {-1, -1, -1};
    cube[k] = static_cast<std::int64_t>(along) + 1;
    if (cube[k] < 1) cube[k] = 1;  // neighbours are asked for too
  }
  return cube;
}

}  // namespace scanknit
