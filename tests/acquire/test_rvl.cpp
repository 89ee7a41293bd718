#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "acquire/ros2/rvl.h"
#include "rvl_writer.h"

namespace scanknit::test::rvl {
namespace {

std::vector<std::byte> bytes_of_words(const std::vector<std::uint8_t>& values) {
  const auto bytes = std::as_bytes(std::span(values));
  return {bytes.begin(), bytes.end()};
}

TEST(Rvl, GivesThePictureThatWasPacked) {
  std::mt19937 random(7);
  for (int round = 0; round < 200; ++round) {
    Image<std::uint16_t> picture(1 + static_cast<int>(random() % 9), 1 + static_cast<int>(random() % 7));
    for (std::uint16_t& depth : picture.pixels()) {
      depth = static_cast<std::uint16_t>(random() % 3 == 0 ? 0 : random() % 2 == 0 ? 1000 + random() % 9 : random());
    }
    const auto packed = RvlWriter(picture.pixels()).bytes();
    const auto unpacked = unpack_rvl(packed, picture.width(), picture.height());
    ASSERT_TRUE(unpacked);
    EXPECT_TRUE(std::ranges::equal(unpacked->pixels(), picture.pixels())) << round;
    for (std::size_t size = 0; size + 4 <= packed.size(); ++size) {
      EXPECT_FALSE(unpack_rvl(std::span(packed).first(size), picture.width(), picture.height())) << size;
    }
  }
}

TEST(Rvl, IsThatOfTheReference) {
  // 0 0 5 5 4: two without depth, three with it, then +5, 0, -1 as 10 (2, then 1), 0 and 1.
  const auto picture = unpack_rvl(bytes_of_words({0x00, 0x01, 0xA1, 0x23}), 5, 1);
  ASSERT_TRUE(picture);
  const auto pixels = picture->pixels();
  EXPECT_EQ(std::vector<std::uint16_t>(pixels.begin(), pixels.end()), (std::vector<std::uint16_t>{0, 0, 5, 5, 4}));
}

TEST(Rvl, ThatPromisesTooMuchIsRefused) {
  const auto unpacked = [](std::vector<std::uint8_t> words) { return unpack_rvl(bytes_of_words(words), 2, 2); };
  EXPECT_FALSE(unpacked({0, 0, 0, 0x50})) << "five without depth";
  EXPECT_FALSE(unpacked({0, 0, 0, 0x25})) << "two, then five";
  EXPECT_FALSE(unpacked({0, 0, 0, 0})) << "runs of nothing";
  EXPECT_FALSE(unpacked({0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF})) << "a number without an end";
}

}  // namespace
}  // namespace scanknit::test::rvl
