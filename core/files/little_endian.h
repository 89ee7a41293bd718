// Appends numbers to bytes that are to be written, lowest byte first on every machine. ByteReader reads them.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <string>

namespace scanknit {

/// T: an integer or float of 1, 2, 4 or 8 bytes.
template <typename T>
void append_little_endian(std::string& bytes, T value) {
  std::array<char, sizeof(T)> raw;
  std::memcpy(raw.data(), &value, sizeof(T));
  if constexpr (std::endian::native == std::endian::big) std::reverse(raw.begin(), raw.end());
  bytes.append(raw.data(), raw.size());
}

}  // namespace scanknit
