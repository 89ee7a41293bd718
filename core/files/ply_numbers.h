// The body of a PLY file as a sequence of numbers.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

#include "core/files/byte_reader.h"
#include "core/files/ply_header.h"

namespace scanknit {

/// Whatever the encoding. Every PLY type fits a double exactly. Reads nothing beyond its end.
class PlyNumbers {
 public:
  PlyNumbers(std::string_view body, PlyEncoding encoding);

  /// Bytes that are left.
  [[nodiscard]] std::size_t remaining() const;

  /// Nothing at the end, or where there is no number.
  [[nodiscard]] std::optional<double> next(PlyType type);

  /// A list's length: a whole number of values that the rest of the file could hold.
  [[nodiscard]] std::optional<std::size_t> next_count(const PlyProperty& list);

  /// Reads past one property.
  [[nodiscard]] bool skip(const PlyProperty& property);

 private:
  template <typename T>
  [[nodiscard]] std::optional<double> binary();

  PlyEncoding encoding_;
  std::string_view text_;
  ByteReader bytes_;
};

}  // namespace scanknit
