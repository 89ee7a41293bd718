// The median of a list.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace scanknit {

/// The median; for an even count the greater of the two middle values; 0 for an empty list. Values must not be NaN.
template <typename Number>
[[nodiscard]] Number median(std::vector<Number> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace scanknit
