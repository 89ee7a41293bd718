// The median and percentiles of a list.
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

/// The value at `share` (0 to 1) of the way from the least to the greatest; 0 for an empty list. Reorders the values,
/// which must not be NaN.
template <typename Number>
[[nodiscard]] Number percentile(std::vector<Number>& values, double share) {
  if (values.empty()) return 0;
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

}  // namespace scanknit
