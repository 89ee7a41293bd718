// SampleType: how a file stores a sample, and how it becomes a float.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "extract/extract_config.h"

namespace scanknit {

/// In the order of the enumeration.
inline constexpr std::array<std::string_view, 10> kSampleTypeNames = {"int8",   "uint8", "int16",  "uint16", "int32",
                                                                      "uint32", "int64", "uint64", "float",  "double"};

[[nodiscard]] std::size_t bytes_per_sample(SampleType type);
/// "int8", "uint8" ... "uint64", "float", "double".
[[nodiscard]] constexpr std::string_view sample_type_name(SampleType type) {
  return kSampleTypeNames[static_cast<std::size_t>(type)];
}
/// The type of that name; nothing for any other word.
[[nodiscard]] constexpr std::optional<SampleType> sample_type_named(std::string_view name) {
  const auto found = std::ranges::find(kSampleTypeNames, name);
  if (found == kSampleTypeNames.end()) return std::nullopt;
  return static_cast<SampleType>(found - kSampleTypeNames.begin());
}
/// The type of a floating-point, signed or unsigned number of 1, 2, 4 or 8 bytes; nothing where there is none.
[[nodiscard]] std::optional<SampleType> sample_type_of(std::size_t bytes, bool is_signed, bool is_floating_point);

/// Whether a float may be unable to hold what the type can: whole numbers beyond 2^24, the last digits of a double.
[[nodiscard]] bool is_rounded_to_float(SampleType type);

/// A sample's value is slope * stored + intercept.
struct Rescale {
  double slope = 1;
  double intercept = 0;
  [[nodiscard]] bool is_identity() const { return slope == 1 && intercept == 0; }
};

/// Fills `samples` from samples.size() * bytes_per_sample(type) bytes: the nearest float, NaN (unobserved) for NaN,
/// infinity and what is beyond the range of float.
void decode_samples(std::span<const std::byte> bytes, SampleType type, ByteOrder order, const Rescale& rescale,
                    std::span<float> samples);

}  // namespace scanknit
