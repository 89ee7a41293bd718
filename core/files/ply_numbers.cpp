#include "core/files/ply_numbers.h"

#include <cmath>
#include <cstdint>
#include <span>

#include "core/files/ascii_numbers.h"

namespace scanknit {

PlyNumbers::PlyNumbers(std::string_view body, PlyEncoding encoding)
    : encoding_(encoding), text_(body), bytes_(std::as_bytes(std::span(body))) {}

std::size_t PlyNumbers::remaining() const {
  return encoding_ == PlyEncoding::kAscii ? text_.size() : bytes_.remaining();
}

std::optional<double> PlyNumbers::next(PlyType type) {
  if (encoding_ == PlyEncoding::kAscii) return parse_double(take_word(text_));
  switch (type) {
    case PlyType::kInt8: return binary<std::int8_t>();
    case PlyType::kUint8: return binary<std::uint8_t>();
    case PlyType::kInt16: return binary<std::int16_t>();
    case PlyType::kUint16: return binary<std::uint16_t>();
    case PlyType::kInt32: return binary<std::int32_t>();
    case PlyType::kUint32: return binary<std::uint32_t>();
    case PlyType::kFloat32: return binary<float>();
    case PlyType::kFloat64: return binary<double>();
  }
  return std::nullopt;
}

std::optional<std::size_t> PlyNumbers::next_count(const PlyProperty& list) {
  const auto count = next(*list.count_type);
  if (!count || !(*count >= 0) || *count > static_cast<double>(remaining()) || *count != std::floor(*count)) {
    return std::nullopt;
  }
  return static_cast<std::size_t>(*count);
}

bool PlyNumbers::skip(const PlyProperty& property) {
  const auto count = property.count_type ? next_count(property) : std::optional<std::size_t>(1);
  if (!count) return false;
  for (std::size_t i = 0; i < *count; ++i) {
    if (!next(property.type)) return false;
  }
  return true;
}

template <typename T>
std::optional<double> PlyNumbers::binary() {
  const auto value = encoding_ == PlyEncoding::kBigEndian ? bytes_.big_endian<T>() : bytes_.little_endian<T>();
  if (!value) return std::nullopt;
  return static_cast<double>(*value);
}

}  // namespace scanknit
