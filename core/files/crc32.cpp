#include "core/files/crc32.h"

#include <zlib.h>

namespace scanknit {

std::uint32_t crc32(std::span<const std::byte> bytes, std::uint32_t before) {
  if (bytes.empty()) return before;  // zlib would begin anew at a null pointer
  const auto* first = reinterpret_cast<const unsigned char*>(bytes.data());
  return static_cast<std::uint32_t>(::crc32_z(before, first, bytes.size()));
}

}  // namespace scanknit
