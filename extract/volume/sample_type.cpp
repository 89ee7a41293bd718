#include "extract/volume/sample_type.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/check.h"

namespace scanknit {
namespace {

struct TypeFacts {
  SampleType type;
  std::size_t bytes;
  bool is_signed;
  bool is_floating_point;
};

// In the order of the enumeration.
constexpr std::array<TypeFacts, 10> kTypes = {{{SampleType::kInt8, 1, true, false},
                                               {SampleType::kUint8, 1, false, false},
                                               {SampleType::kInt16, 2, true, false},
                                               {SampleType::kUint16, 2, false, false},
                                               {SampleType::kInt32, 4, true, false},
                                               {SampleType::kUint32, 4, false, false},
                                               {SampleType::kInt64, 8, true, false},
                                               {SampleType::kUint64, 8, false, false},
                                               {SampleType::kFloat, 4, true, true},
                                               {SampleType::kDouble, 8, true, true}}};

const TypeFacts& facts(SampleType type) {
  return kTypes[static_cast<std::size_t>(type)];
}

template <typename Number>
float to_sample(Number value) {
  const auto sample = static_cast<float>(value);
  return std::isfinite(sample) ? sample : std::numeric_limits<float>::quiet_NaN();
}

template <typename Stored>
void decode(std::span<const std::byte> bytes, bool is_swapped, const Rescale& rescale, std::span<float> samples) {
  const bool is_identity = rescale.is_identity();
  for (std::size_t n = 0; n < samples.size(); ++n) {
    std::array<std::byte, sizeof(Stored)> raw;
    std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(n * sizeof(Stored)), sizeof(Stored), raw.begin());
    if (is_swapped) std::reverse(raw.begin(), raw.end());
    const auto stored = std::bit_cast<Stored>(raw);
    samples[n] =
        is_identity ? to_sample(stored) : to_sample(rescale.slope * static_cast<double>(stored) + rescale.intercept);
  }
}

}  // namespace

std::size_t bytes_per_sample(SampleType type) {
  return facts(type).bytes;
}

std::optional<SampleType> sample_type_of(std::size_t bytes, bool is_signed, bool is_floating_point) {
  const auto found = std::ranges::find_if(kTypes, [&](const TypeFacts& t) {
    return t.bytes == bytes && t.is_floating_point == is_floating_point &&
           (is_floating_point || t.is_signed == is_signed);
  });
  return found == kTypes.end() ? std::nullopt : std::optional(found->type);
}

bool is_rounded_to_float(SampleType type) {
  return bytes_per_sample(type) > (facts(type).is_floating_point ? sizeof(float) : sizeof(std::int16_t));
}

void decode_samples(std::span<const std::byte> bytes, SampleType type, ByteOrder order, const Rescale& rescale,
                    std::span<float> samples) {
  SCANKNIT_CHECK(bytes.size() == samples.size() * bytes_per_sample(type));
  const bool is_swapped = (order == ByteOrder::kLittle) != (std::endian::native == std::endian::little);
  switch (type) {
    case SampleType::kInt8: return decode<std::int8_t>(bytes, is_swapped, rescale, samples);
    case SampleType::kUint8: return decode<std::uint8_t>(bytes, is_swapped, rescale, samples);
    case SampleType::kInt16: return decode<std::int16_t>(bytes, is_swapped, rescale, samples);
    case SampleType::kUint16: return decode<std::uint16_t>(bytes, is_swapped, rescale, samples);
    case SampleType::kInt32: return decode<std::int32_t>(bytes, is_swapped, rescale, samples);
    case SampleType::kUint32: return decode<std::uint32_t>(bytes, is_swapped, rescale, samples);
    case SampleType::kInt64: return decode<std::int64_t>(bytes, is_swapped, rescale, samples);
    case SampleType::kUint64: return decode<std::uint64_t>(bytes, is_swapped, rescale, samples);
    case SampleType::kFloat: return decode<float>(bytes, is_swapped, rescale, samples);
    case SampleType::kDouble: return decode<double>(bytes, is_swapped, rescale, samples);
  }
}

}  // namespace scanknit
