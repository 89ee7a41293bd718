#include <gtest/gtest.h>

#include <cstdint>
#include <limits>

#include "core/checked_math.h"

namespace scanknit {
namespace {

TEST(CheckedMul, GivesTheProductThatFits) {
  EXPECT_EQ(checked_mul<std::uint32_t>(65535, 65537), 4294967295u);
}

TEST(CheckedMul, RefusesTheProductThatDoesNot) {
  EXPECT_FALSE(checked_mul<std::uint32_t>(65536, 65536));
  EXPECT_FALSE(checked_mul<std::size_t>(std::numeric_limits<std::size_t>::max(), 2));
  EXPECT_FALSE(checked_mul<std::int32_t>(std::numeric_limits<std::int32_t>::min(), -1));
}

TEST(CheckedNarrow, KeepsTheValueOrRefuses) {
  EXPECT_EQ(checked_narrow<std::uint8_t>(255), std::uint8_t{255});
  EXPECT_FALSE(checked_narrow<std::uint8_t>(256));
  EXPECT_FALSE(checked_narrow<std::uint32_t>(-1));
}

}  // namespace
}  // namespace scanknit
