// Guarded: a double that knows how wrong it may be.
#pragma once

#include <cmath>

namespace scanknit {

/// The exact result of the same operations lies within `error` of `value`: running error analysis (Wilkinson 1986; as a
/// filter of geometric predicates: Shewchuk 1997). Operations are +, -, * on finite values far from overflow.
struct Guarded {
  double value = 0;
  double error = 0;

  Guarded() = default;
  Guarded(double exact) : value(exact) {}  // NOLINT(google-explicit-constructor): a number like others
  Guarded(double v, double e) : value(v), error(e) {}

  friend Guarded operator-(const Guarded& a) { return {-a.value, a.error}; }
  friend Guarded operator+(const Guarded& a, const Guarded& b) {
    const double sum = a.value + b.value;
    return {sum, kSlack * (a.error + b.error + kRounding * std::abs(sum))};
  }
  friend Guarded operator-(const Guarded& a, const Guarded& b) { return a + -b; }
  friend Guarded operator*(const Guarded& a, const Guarded& b) {
    const double product = a.value * b.value;
    const double carried = std::abs(a.value) * b.error + std::abs(b.value) * a.error + a.error * b.error;
    const bool is_zero = (a.value == 0 && a.error == 0) || (b.value == 0 && b.error == 0);
    return {product, is_zero ? 0 : kSlack * (carried + kRounding * std::abs(product)) + kUnderflow};
  }

 private:
  static constexpr double kRounding = 0x1p-53;   ///< of one operation
  static constexpr double kSlack = 1 + 0x1p-48;  ///< of the few operations that make the bound
  static constexpr double kUnderflow = 0x1p-1000;
};

/// -1, 0 or 1; where the error leaves a choice, 0, and a note of it.
class GuardedSign {
 public:
  int operator()(const Guarded& x) {
    if (std::abs(x.value) > x.error) return x.value > 0 ? 1 : -1;
    is_in_doubt_ = is_in_doubt_ || x.error > 0;
    return 0;
  }
  [[nodiscard]] bool is_in_doubt() const { return is_in_doubt_; }

 private:
  bool is_in_doubt_ = false;
};

}  // namespace scanknit
