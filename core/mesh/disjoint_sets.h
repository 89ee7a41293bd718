// A union-find structure.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace scanknit {

/// Initially each number from 0 is a set of its own. The result does not depend on the order of joins.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t size) { reset(size); }

  /// Starts again, without a new allocation.
  void reset(std::size_t size) {
    parent_.resize(size);
    std::iota(parent_.begin(), parent_.end(), 0u);
  }

  /// The smallest number in the set of `of`.
  [[nodiscard]] std::uint32_t root(std::uint32_t of) {
    while (parent_[of] != of) of = parent_[of] = parent_[parent_[of]];
    return of;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = root(a);
    b = root(b);
    if (a != b) parent_[std::max(a, b)] = std::min(a, b);
  }
  [[nodiscard]] std::size_t sets() const {
    std::size_t roots = 0;
    for (std::size_t i = 0; i < parent_.size(); ++i) roots += parent_[i] == i ? 1 : 0;
    return roots;
  }

 private:
  std::vector<std::uint32_t> parent_;
};

}  // namespace scanknit
