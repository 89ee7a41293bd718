// The body of a PLY file as a sequence of numbers.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

#include "core/files/byte_reader.h"
#include "core/files/ply_header.h"

namespace scanknit {

/// Reads both encodings. A double holds every PLY type exactly. Never reads beyond the end.
class PlyNumbers {
 public:
  PlyNumbers(std::string_view body, PlyEncoding encoding);

  /// The number of bytes left.
  [[nodiscard]] std::size_t remaining() const;

  /// The next number; nothing at the end, or if there is no number.
  [[nodiscard]] std::optional<double> next(PlyType type);

  /// The length of a list; nothing unless it is a whole number and the rest of the file can hold so many values.
  [[nodiscard]] std::optional<std::size_t> next_count(const PlyProperty& list);

  /// Skips one property.
  [[nodiscard]] bool skip(const PlyProperty& property);

 private:
  template <typename T>
  [[nodiscard]] std::optional<double> binary();

  PlyEncoding encoding_;
  std::string_view text_;
  ByteReader bytes_;
};

}  // namespace scanknit
