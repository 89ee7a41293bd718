#include "core/voxel_codes.h"

#include <gtest/gtest.h>

namespace scanknit {
namespace {

TEST(WeightCode, IsZeroForNoWeightOnly) {
  EXPECT_EQ(encode_weight(0), 0);
  EXPECT_EQ(decode_weight(0), 0.0f);
  EXPECT_EQ(encode_weight(1e-30f), 1);
  EXPECT_GT(decode_weight(1), 0.0f);
}

TEST(WeightCode, EveryCodeSurvives) {
  for (unsigned code = 0; code <= 0xFFFF; ++code)
    ASSERT_EQ(encode_weight(decode_weight(static_cast<WeightCode>(code))), code);
}

TEST(WeightCode, IsWithinAThousandthFromOneOn) {
  for (float weight = 1; weight < kMaxCodedWeight; weight *= 1.01f)
    EXPECT_NEAR(decode_weight(encode_weight(weight)) / weight, 1.0f, 0.001f);
}

TEST(WeightCode, EndsAtItsLimit) {
  EXPECT_EQ(decode_weight(encode_weight(1e9f)), kMaxCodedWeight);
}

TEST(ColourCode, GivesBackColourAndQuality) {
  const ColourCode code = encode_colour({1, 128, 255}, 7);
  EXPECT_EQ(decode_colour(code), (Rgb8{1, 128, 255}));
  EXPECT_TRUE(has_colour(code));
  EXPECT_FALSE(has_colour(encode_colour({1, 128, 255}, 0)));
}

}  // namespace
}  // namespace scanknit
