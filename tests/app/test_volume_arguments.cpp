#include <gtest/gtest.h>

#include "app/config/volume_arguments.h"

namespace scanknit {
namespace {

TEST(VolumeArguments, DimsAreThreeWholeNumbers) {
  EXPECT_EQ(parse_dims("256x255x108"), Eigen::Vector3i(256, 255, 108));
  for (const char* text : {"", "256", "256x256", "1x2x3x4", "0x2x3", "-1x2x3", "1.5x2x3", "1xx3", "99999999999x1x1"}) {
    EXPECT_FALSE(parse_dims(text)) << text;
  }
}

TEST(VolumeArguments, HeaderBytesAreAWholeNumber) {
  EXPECT_EQ(parse_header_bytes("0"), 0u);
  EXPECT_EQ(parse_header_bytes("352"), 352u);
  for (const char* text : {"", "-1", "1.5", "x", "99999999999999999999"})
    EXPECT_FALSE(parse_header_bytes(text)) << text;
}

TEST(VolumeArguments, SpacingIsOneNumberOrThree) {
  EXPECT_EQ(parse_spacing("0.5"), Eigen::Vector3d(0.5, 0.5, 0.5));
  EXPECT_EQ(parse_spacing("0.5x0.25x1.2"), Eigen::Vector3d(0.5, 0.25, 1.2));
  for (const char* text : {"", "0", "-1", "nan", "inf", "1x2", "1x2x", "1,2,3", "1mm"}) {
    EXPECT_FALSE(parse_spacing(text)) << text;
  }
}

}  // namespace
}  // namespace scanknit
