// two_digits(): a length that is chosen for the user.
#pragma once

#include <cmath>

namespace scanknit {

/// Rounded to two significant digits. `metres` > 0.
[[nodiscard]] inline double two_digits(double metres) {
  const double digit = std::pow(10.0, std::floor(std::log10(metres)) - 1);
  return std::round(metres / digit) * digit;
}

}  // namespace scanknit
