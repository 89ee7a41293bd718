// Proposes an isovalue from a volume's values.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "core/result.h"

namespace scanknit {

/// Counts values and their distribution in bounded memory. Ignores NaN and infinity.
class ValueCensus {
 public:
  ValueCensus() : counts_(std::size_t{1} << 16, 0) {}
  void add(std::span<const float> values);

  [[nodiscard]] std::uint64_t count() const { return count_; }
  [[nodiscard]] float min() const { return min_; }  ///< +infinity without values
  [[nodiscard]] float max() const { return max_; }  ///< -infinity without values
  /// An interval that holds all values except at most the share `share` (0 to 1/2) of them at either end. Its ends are
  /// within 1 % of the values there.
  struct Interval {
    float low, high;
  };
  [[nodiscard]] Interval without_outliers(double share) const;

 private:
  std::vector<std::uint64_t> counts_;  ///< counts by the 16 highest bits of the value, in the order of the values
  std::uint64_t count_ = 0;
  float min_ = std::numeric_limits<float>::infinity();
  float max_ = -std::numeric_limits<float>::infinity();
};

/// Counts of the values within [low, high], low < high, in bins of equal width.
struct Histogram {
  static constexpr std::size_t kBins = 1024;
  double low = 0, high = 1;
  std::array<std::uint64_t, kBins> counts{};
  void add(std::span<const float> values);
  [[nodiscard]] double bin_width() const { return (high - low) / static_cast<double>(kBins); }
};

/// Otsu 1979, "A threshold selection method from gray-level histograms", eq. (18): the border between bins that divides
/// the values into two classes with the largest variance between them; the middle of all borders that are equally good.
/// Nothing when fewer than two bins are occupied.
[[nodiscard]] std::optional<double> otsu_threshold(const Histogram& histogram);

/// Passes all values of a volume to its argument, in pieces; can be called several times.
using ValueSource = std::function<Result<void>(const std::function<void(std::span<const float>)>&)>;

/// The message for a volume without any finite value.
inline constexpr const char* kNoFiniteSample = "there is not one finite sample";

/// Otsu's threshold of the values, to a tenth of a bin, without the lowest and highest 0.1 % of them. Reads the values
/// two or three times. Errors: those of `values`; kInput when all values are equal, or there is none.
[[nodiscard]] Result<double> propose_isovalue(const ValueSource& values);

}  // namespace scanknit
