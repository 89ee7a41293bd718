#include <gtest/gtest.h>

#include <limits>

#include "export/texture/srgb.h"

namespace scanknit {
namespace {

TEST(Srgb, EveryByteComesBack) {
  for (int i = 0; i < 256; ++i) {
    const auto byte = static_cast<std::uint8_t>(i);
    EXPECT_EQ(srgb_from_linear(linear_from_srgb(byte)), byte);
  }
}

TEST(Srgb, EveryByteComesBackThroughSixteenBits) {
  for (int i = 0; i < 256; ++i) {
    const auto byte = static_cast<std::uint8_t>(i);
    EXPECT_EQ(srgb_from_linear(static_cast<double>(std::lround(65535 * linear_from_srgb(byte))) / 65535), byte);
  }
}

TEST(Srgb, EndsAreExact) {
  EXPECT_EQ(linear_from_srgb(0), 0.0);
  EXPECT_EQ(linear_from_srgb(255), 1.0);
}

TEST(Srgb, MiddleGreyIsAFifthOfTheLight) {
  constexpr double kFiveDigits = 1e-5;
  EXPECT_NEAR(linear_from_srgb(128), 0.21586, kFiveDigits);  // ((128/255 + 0.055) / 1.055)^2.4
}

TEST(Srgb, ClampsWhatIsNoLight) {
  EXPECT_EQ(srgb_from_linear(-1), 0);
  EXPECT_EQ(srgb_from_linear(7), 255);
  EXPECT_EQ(srgb_from_linear(std::numeric_limits<double>::quiet_NaN()), 0);
}

}  // namespace
}  // namespace scanknit
