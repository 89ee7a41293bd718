#include "scan/volume/auto_isovalue.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace scanknit {
namespace {

/// Maps floats to unsigned integers in the same order: flips the sign bit, and for negative numbers all other bits too.
std::uint32_t ordered_bits(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  return (bits >> 31) != 0 ? ~bits : bits | 0x8000'0000u;
}

float value_of_ordered(std::uint32_t ordered) {
  return std::bit_cast<float>((ordered >> 31) != 0 ? ordered & 0x7FFF'FFFFu : ~ordered);
}

/// `value` without the digits that are worth less than `step`: short enough to type.
double rounded(double value, double step) {
  constexpr double kMostDecimals = 15;
  const double decimals = std::max(0.0, -std::floor(std::log10(step)));
  if (decimals > kMostDecimals) return value;
  const double scale = std::pow(10.0, decimals);
  return std::round(value * scale) / scale;
}

}  // namespace

void ValueCensus::add(std::span<const float> values) {
  for (const float value : values) {
    if (!std::isfinite(value)) continue;
    ++counts_[ordered_bits(value) >> 16];
    ++count_;
    min_ = std::min(min_, value);
    max_ = std::max(max_, value);
  }
}

ValueCensus::Interval ValueCensus::without_outliers(double share) const {
  const auto allowed = static_cast<std::uint64_t>(share * static_cast<double>(count_));
  std::uint32_t first = 0;
  std::uint32_t last = 0xFFFF;
  for (std::uint64_t below = counts_[first]; below <= allowed && first < last; below += counts_[first]) ++first;
  for (std::uint64_t above = counts_[last]; above <= allowed && first < last; above += counts_[last]) --last;
  return {std::max(min_, value_of_ordered(first << 16)), std::min(max_, value_of_ordered(last << 16 | 0xFFFF))};
}

void Histogram::add(std::span<const float> values) {
  const double bins_per_unit = 1 / bin_width();
  for (const float value : values) {
    if (!(value >= low && value <= high)) continue;  // NaN too
    const auto bin = static_cast<std::size_t>((value - low) * bins_per_unit);
    ++counts[std::min(bin, kBins - 1)];
  }
}

std::optional<double> otsu_threshold(const Histogram& histogram) {
  double total = 0, total_moment = 0;
  for (std::size_t bin = 0; bin < Histogram::kBins; ++bin) {
    total += static_cast<double>(histogram.counts[bin]);
    total_moment += static_cast<double>(bin) * static_cast<double>(histogram.counts[bin]);
  }
  double count = 0, moment = 0, best = 0;
  std::size_t first_best = 0, last_best = 0;
  for (std::size_t bin = 0; bin + 1 < Histogram::kBins; ++bin) {
    count += static_cast<double>(histogram.counts[bin]);
    moment += static_cast<double>(bin) * static_cast<double>(histogram.counts[bin]);
    if (count == 0 || count == total) continue;
    // Equation (18), times total^2: the variance between the classes up to this bin and beyond it.
    const double difference = total_moment * count - moment * total;
    const double between = difference / count * (difference / (total - count));
    if (between > best) {
      best = between;
      first_best = bin;
    }
    if (between == best) last_best = bin;
  }
  if (best == 0) return std::nullopt;
  const double border = static_cast<double>(first_best + last_best + 2) / 2;
  return histogram.low + border * histogram.bin_width();
}

Result<double> propose_isovalue(const ValueSource& values) {
  constexpr double kOutliers = 0.001;
  ValueCensus census;
  if (auto read = values([&](std::span<const float> piece) { census.add(piece); }); !read) return read.error();
  if (census.count() == 0) return Error{ErrorCode::kInput, kNoFiniteSample};
  const ValueCensus::Interval whole{census.min(), census.max()};
  // The second interval is for volumes in which nearly all values are equal: the first one has no width there.
  for (const auto& [low, high] : {census.without_outliers(kOutliers), whole}) {
    if (!(low < high)) continue;
    Histogram histogram{low, high, {}};
    if (auto read = values([&](std::span<const float> piece) { histogram.add(piece); }); !read) return read.error();
    if (const auto threshold = otsu_threshold(histogram)) return rounded(*threshold, histogram.bin_width() / 10);
  }
  return Error{ErrorCode::kInput, "all values are equal, so there is no surface; set extract.isovalue"};
}

}  // namespace scanknit
