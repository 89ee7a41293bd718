// CRC-32, whole and in parts.
#include <gtest/gtest.h>

#include <span>
#include <string_view>

#include "core/files/crc32.h"

namespace scanknit {
namespace {

std::span<const std::byte> bytes_in(std::string_view text) {
  return std::as_bytes(std::span(text));
}

TEST(Crc32, IsThatOfTheStandardsCheck) {
  EXPECT_EQ(crc32(bytes_in("123456789")), 0xCBF43926u);
}

TEST(Crc32, GoesOnFromPartsAlsoFromEmptyOnes) {
  EXPECT_EQ(crc32(bytes_in("56789"), crc32({}, crc32(bytes_in("1234")))), 0xCBF43926u);
  EXPECT_EQ(crc32({}), 0u);
}

}  // namespace
}  // namespace scanknit
