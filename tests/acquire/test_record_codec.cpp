// The depth codec and the picture messages: lossless, and safe with any bytes.
#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "acquire/mcap/byte_appender.h"
#include "acquire/mcap/zstd_bytes.h"
#include "acquire/record/depth_codec.h"
#include "acquire/record/picture_message.h"
#include "core/files/crc32.h"
#include "raw_frames.h"

namespace scanknit::test {
namespace {

std::vector<std::byte> random_bytes(std::size_t count, std::uint32_t seed) {
  std::minstd_rand random(seed);
  std::vector<std::byte> bytes(count);
  for (std::byte& b : bytes) b = static_cast<std::byte>(random() >> 8 & 0xFF);
  return bytes;
}

std::vector<std::byte> little_endian(const std::vector<std::uint16_t>& values) {
  std::vector<std::byte> bytes;
  ByteAppender writer(bytes);
  for (const std::uint16_t value : values) writer.little_endian(value);
  return bytes;
}

TEST(DepthCodec, GivesBackWhatItWasGiven) {
  for (const std::size_t pixels : {0u, 1u, 2u, 15u, 16u, 17u, 4096u}) {
    const auto bytes = random_bytes(2 * pixels, static_cast<std::uint32_t>(pixels + 1));
    EXPECT_EQ(decode_depth(encode_depth(bytes), pixels).value(), bytes) << pixels << " pixels";
  }
}

TEST(DepthCodec, KeepsEveryStepBetweenTwoValues) {
  std::vector<std::uint16_t> values;
  for (unsigned step = 0; step < 65536; ++step) {
    values.push_back(static_cast<std::uint16_t>(step * 40503u));
    values.push_back(static_cast<std::uint16_t>(step * 40503u + step));
  }
  const auto bytes = little_endian(values);
  EXPECT_EQ(decode_depth(encode_depth(bytes), values.size()).value(), bytes);
}

// The format's definition, by hand: 1, 2, 2 are steps of +1, +1, 0; zigzag doubles them; low bytes, then high bytes.
TEST(DepthCodec, IsWrittenAsItsDescriptionSays) {
  const auto planes = zstd_unpack(encode_depth(little_endian({1, 2, 2, 1, 0x0101})), 10).value();
  const std::vector<std::byte> expected = {std::byte{2}, std::byte{2}, std::byte{0}, std::byte{1}, std::byte{0},
                                           std::byte{0}, std::byte{0}, std::byte{0}, std::byte{0}, std::byte{2}};
  EXPECT_EQ(planes, expected);
}

TEST(DepthCodec, MakesDepthSmaller) {
  const auto bytes = depth_bytes(640, 480, 1);
  EXPECT_LT(encode_depth(bytes).size(), bytes.size() / 4);
}

TEST(DepthCodec, RefusesAnotherNumberOfPixels) {
  const auto packed = encode_depth(random_bytes(200, 3));
  EXPECT_TRUE(decode_depth(packed, 100));
  EXPECT_FALSE(decode_depth(packed, 99));
  EXPECT_FALSE(decode_depth(packed, 101));
}

TEST(DepthCodec, RefusesWhatIsCutAtAnyByte) {
  const auto packed = encode_depth(depth_bytes(32, 24, 2));
  for (std::size_t size = 0; size < packed.size(); ++size) {
    EXPECT_FALSE(decode_depth(std::span(packed).first(size), 32 * 24)) << size << " bytes";
  }
}

class PictureMessage : public ::testing::TestWithParam<PixelFormat> {};

TEST_P(PictureMessage, GivesBackTheFrame) {
  RawFrame frame = depth_frame(7);
  frame.profile.format = GetParam();
  frame.profile.kind = GetParam() == PixelFormat::kZ16 ? StreamKind::kDepth : StreamKind::kColour;
  frame.profile.frames_per_second = 29.97;
  const auto unpacked = unpack_picture(pack_picture(frame), {});
  ASSERT_TRUE(unpacked) << unpacked.error().text();
  EXPECT_EQ(unpacked->profile, frame.profile);
  EXPECT_EQ(unpacked->sequence, frame.sequence);
  EXPECT_EQ(*unpacked->bytes, *frame.bytes);
}

INSTANTIATE_TEST_SUITE_P(AllFormats, PictureMessage,
                         ::testing::Values(PixelFormat::kZ16, PixelFormat::kYuyv, PixelFormat::kUyvy,
                                           PixelFormat::kMjpeg, PixelFormat::kRgb8, PixelFormat::kBgr8,
                                           PixelFormat::kY8i),
                         [](const auto& format) { return std::string(to_string(format.param)); });

TEST(PictureMessage, KeepsTheCamerasJpegByteForByte) {
  RawFrame frame = colour_frame(1);
  frame.profile.format = PixelFormat::kMjpeg;
  const auto message = pack_picture(frame);
  EXPECT_EQ(std::vector<std::byte>(message.begin() + 32, message.end()), *frame.bytes);
}

TEST(PictureMessage, KeepsADepthPictureOfAnOddSizeToo) {
  RawFrame frame = depth_frame(1);
  frame.bytes = share(random_bytes(77, 5));
  EXPECT_EQ(*unpack_picture(pack_picture(frame), {})->bytes, *frame.bytes);
}

TEST(PictureMessage, IsRefusedWhenCutAtAnyByte) {
  const auto message = pack_picture(depth_frame(1, 16, 12));
  for (std::size_t size = 0; size < message.size(); ++size) {
    EXPECT_FALSE(unpack_picture(std::span(message).first(size), {})) << size << " bytes";
  }
}

TEST(PictureMessage, SurvivesAnyWrongByte) {
  const auto whole = pack_picture(depth_frame(1, 16, 12));
  for (std::size_t i = 0; i < whole.size(); ++i) {
    auto message = whole;
    message[i] ^= std::byte{0xFF};
    const auto unpacked = unpack_picture(message, {});
    if (unpacked) {
      EXPECT_LE(unpacked->bytes->size(), Limits{}.max_image_bytes);
    }
  }
}

// A header of a few bytes that asks for gigabytes.
TEST(PictureMessage, AsksForNoMemoryBeyondTheLimits) {
  auto message = pack_picture(colour_frame(1));
  ByteAppender writer(message);
  writer.put(4, std::uint32_t{60'000});
  writer.put(8, std::uint32_t{60'000});
  EXPECT_FALSE(unpack_picture(message, {}));
  writer.put(4, std::uint32_t{0});
  EXPECT_FALSE(unpack_picture(message, {}));
  message = pack_picture(colour_frame(1));
  ByteAppender(message).put(12, std::uint32_t{0xFFFF'FFFF});
  EXPECT_FALSE(unpack_picture(message, {}));
}

TEST(Crc32, IsTheOneOfTheStandard) {
  const std::string check = "123456789";
  const auto bytes = std::as_bytes(std::span(check));
  EXPECT_EQ(crc32(bytes), 0xCBF43926u);  // the check value of CRC-32/ISO-HDLC
  EXPECT_EQ(crc32(bytes.subspan(4), crc32(bytes.first(4))), 0xCBF43926u);
  EXPECT_EQ(crc32({}), 0u);
}

}  // namespace
}  // namespace scanknit::test
