// The header of a PLY file: which elements follow, how many, and how each is laid out.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace scanknit {

enum class PlyEncoding { kAscii, kLittleEndian, kBigEndian };
enum class PlyType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

[[nodiscard]] std::size_t size_of(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type;                       ///< of the value, or of a list's values
  std::optional<PlyType> count_type;  ///< a list's length precedes it, in this type
};

struct PlyElement {
  std::string name;
  std::size_t count = 0;
  std::vector<PlyProperty> properties;

  /// The fewest bytes one element can take; lists may be empty.
  [[nodiscard]] std::size_t min_bytes(PlyEncoding encoding) const;
};

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::kAscii;
  std::vector<PlyElement> elements;
  std::vector<std::string> obj_info;  ///< what follows the keyword, in the order of the file
  std::size_t body_offset = 0;        ///< of the first byte after "end_header"
};

/// Parses counts without checking them against the file or any limit. Errors: kInput.
[[nodiscard]] Result<PlyHeader> parse_ply_header(std::string_view bytes);

}  // namespace scanknit
