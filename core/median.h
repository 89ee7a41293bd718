// The median of a list.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace scanknit {

/// The greater of the two middle ones when their number is even; 0 of an empty list. NaN is no value.
template <typename Number>
[[nodiscard]] Number median(std::vector<Number> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace scanknit
