// The header of a PCD file (PCL's point cloud format 0.6 and 0.7), checked against the file that carries it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/limits.h"
#include "core/result.h"

namespace scanknit {

enum class PcdEncoding { kAscii, kBinary, kBinaryCompressed };

struct PcdField {
  std::string name;
  char type = 'F';         ///< I, U or F
  std::size_t size = 4;    ///< bytes of one element
  std::size_t count = 1;   ///< elements of one point
  std::size_t offset = 0;  ///< bytes from the point's begin
};

struct PcdHeader {
  std::vector<PcdField> fields;
  int width = 0;
  int height = 0;
  std::array<double, 7> viewpoint{0, 0, 0, 1, 0, 0, 0};  ///< tx ty tz qw qx qy qz
  PcdEncoding encoding = PcdEncoding::kAscii;
  std::size_t point_bytes = 0;   ///< of one point in binary form
  std::size_t header_bytes = 0;  ///< up to and with the newline after DATA
};

/// Reads the header and checks that the rest of `bytes` can hold the points it announces. Errors (kInput): not a PCD,
/// malformed, sizes beyond the limits or beyond the file, truncated.
[[nodiscard]] Result<PcdHeader> parse_pcd_header(std::span<const std::byte> bytes, const Limits& limits);

}  // namespace scanknit
