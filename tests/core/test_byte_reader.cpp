#include <gtest/gtest.h>

#include <array>

#include "core/files/byte_reader.h"

namespace scanknit {
namespace {

constexpr std::array kBytes = {std::byte{0x01}, std::byte{0x02}, std::byte{0x03}, std::byte{0x04}, std::byte{0x05}};

TEST(ByteReader, ReadsLittleEndian) {
  ByteReader reader(kBytes);
  EXPECT_EQ(reader.little_endian<std::uint32_t>(), 0x04030201u);
}

TEST(ByteReader, ReadsBigEndian) {
  ByteReader reader(kBytes);
  EXPECT_EQ(reader.big_endian<std::uint32_t>(), 0x01020304u);
}

TEST(ByteReader, ReadsFloatsOfEitherOrder) {
  constexpr std::array one = {std::byte{0}, std::byte{0}, std::byte{0x80}, std::byte{0x3F}};
  constexpr std::array one_big = {std::byte{0x3F}, std::byte{0x80}, std::byte{0}, std::byte{0}};
  EXPECT_EQ(ByteReader(one).little_endian<float>(), 1.0f);
  EXPECT_EQ(ByteReader(one_big).big_endian<float>(), 1.0f);
}

TEST(ByteReader, GivesNothingAndMovesNothingPastTheEnd) {
  ByteReader reader(kBytes);
  ASSERT_TRUE(reader.take(3));
  EXPECT_FALSE(reader.little_endian<std::uint32_t>());
  EXPECT_EQ(reader.offset(), 3u);
  EXPECT_EQ(reader.remaining(), 2u);
  EXPECT_EQ(reader.little_endian<std::uint16_t>(), 0x0504);
}

TEST(ByteReader, RefusesACountThatWouldOverflow) {
  ByteReader reader(kBytes);
  ASSERT_TRUE(reader.take(1));
  EXPECT_FALSE(reader.take(static_cast<std::size_t>(-1)));
  EXPECT_EQ(reader.offset(), 1u);
}

TEST(ByteReader, TakesNothingFromNothing) {
  ByteReader reader({});
  EXPECT_TRUE(reader.take(0));
  EXPECT_FALSE(reader.take(1));
}

}  // namespace
}  // namespace scanknit
