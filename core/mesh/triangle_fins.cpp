#include "core/mesh/triangle_fins.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace scanknit {
namespace {

/// The corners in a cyclic order that begins with the smallest: it is even if the other two ascend.
Triangle from_smallest(Triangle t) {
  std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  return t;
}

bool is_even(const Triangle& t) {
  const Triangle turned = from_smallest(t);
  return turned[1] < turned[2];
}

}  // namespace

void remove_fins(std::vector<Triangle>& triangles) {
  using Sorted = std::array<std::uint32_t, 4>;  // the corners, ascending, and the triangle
  std::vector<Sorted> all;
  all.reserve(triangles.size());
  for (const Triangle& triangle : triangles) {
    const Triangle t = from_smallest(triangle);
    all.push_back({t[0], std::min(t[1], t[2]), std::max(t[1], t[2]), static_cast<std::uint32_t>(all.size())});
  }
  std::sort(all.begin(), all.end());
  std::vector<std::uint8_t> is_fin(triangles.size());
  for (std::size_t i = 1; i < all.size(); ++i) {
    const std::uint32_t x = all[i - 1][3], y = all[i][3];
    if (!std::equal(all[i].begin(), all[i].begin() + 3, all[i - 1].begin()) ||
        is_even(triangles[x]) == is_even(triangles[y]) || is_fin[x] != 0) {
      continue;
    }
    is_fin[x] = is_fin[y] = 1;
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < is_fin.size(); ++i) {
    if (is_fin[i] == 0) triangles[kept++] = triangles[i];
  }
  triangles.resize(kept);
}

}  // namespace scanknit
