#include "acquire/crc32.h"

#include <array>

namespace scanknit {
namespace {

constexpr std::size_t kSlices = 8;  // bytes that are looked up at once (M. E. Kounavis and F. L. Berry 2005)
using Tables = std::array<std::array<std::uint32_t, 256>, kSlices>;

// tables[k][b]: what byte b has become when k more bytes have passed.
constexpr Tables make_tables() {
  Tables tables{};
  for (std::uint32_t n = 0; n < 256; ++n) {
    std::uint32_t c = n;
    for (int k = 0; k < 8; ++k) c = (c & 1) != 0 ? 0xEDB88320u ^ (c >> 1) : c >> 1;
    tables[0][n] = c;
  }
  for (std::size_t k = 1; k < kSlices; ++k) {
    for (std::size_t n = 0; n < 256; ++n) {
      tables[k][n] = tables[0][tables[k - 1][n] & 0xFF] ^ (tables[k - 1][n] >> 8);
    }
  }
  return tables;
}

constexpr Tables kTables = make_tables();

}  // namespace

std::uint32_t crc32(std::span<const std::byte> bytes, std::uint32_t before) {
  std::uint32_t c = ~before;
  while (bytes.size() >= kSlices) {
    std::uint32_t next = 0;
    for (std::size_t i = 0; i < kSlices; ++i) {
      const std::uint32_t folded = i < 4 ? c >> (8 * i) : 0;
      next ^= kTables[kSlices - 1 - i][(folded ^ std::to_integer<std::uint32_t>(bytes[i])) & 0xFF];
    }
    c = next;
    bytes = bytes.subspan(kSlices);
  }
  for (const std::byte b : bytes) c = kTables[0][(c ^ std::to_integer<std::uint32_t>(b)) & 0xFF] ^ (c >> 8);
  return ~c;
}

}  // namespace scanknit
