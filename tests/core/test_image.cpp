#include <gtest/gtest.h>

#include "core/image.h"

namespace scanknit {
namespace {

TEST(Image, IsEmptyByDefault) {
  EXPECT_TRUE(DepthImage{}.empty());
  EXPECT_FALSE(DepthImage{}.contains(0, 0));
}

TEST(Image, IsRowMajorFromTheTop) {
  Image<int> image(3, 2);
  image.at(2, 1) = 7;
  EXPECT_EQ(image.pixels()[5], 7);
  EXPECT_EQ(image.row(1)[2], 7);
  EXPECT_EQ(image.row(0).size(), 3u);
}

TEST(Image, FillsWithWhatItIsGiven) {
  const ColourImage image(2, 2, Rgb8{1, 2, 3});
  for (const Rgb8 pixel : image.pixels()) EXPECT_EQ(pixel, (Rgb8{1, 2, 3}));
}

TEST(Image, ContainsItsPixelsOnly) {
  const DepthImage image(3, 2);
  EXPECT_TRUE(image.contains(2, 1));
  EXPECT_FALSE(image.contains(3, 1));
  EXPECT_FALSE(image.contains(0, 2));
  EXPECT_FALSE(image.contains(-1, 0));
}

}  // namespace
}  // namespace scanknit
