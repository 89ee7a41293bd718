// Pictures: what is decoded, what is refused before any library sees it.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "acquire/replay/picture_codec.h"
#include "acquire/replay/undistort.h"
#include "core/picture/decode_picture.h"
#include "core/picture/jpeg_structure.h"
#include "test_replay_support.h"

namespace scanknit::test {
namespace {

std::vector<std::byte> depth_png() {
  const TemporaryFolder folder;
  write_depth(folder / "d.png", 1234);
  return bytes_of(folder / "d.png");
}

std::vector<std::byte> colour_file(const char* name, Rgb8 colour = {200, 100, 50}) {
  const TemporaryFolder folder;
  write_colour(folder / name, colour, 16, 16);
  return bytes_of(folder / name);
}

// Writes another size into IHDR, with a CRC that is right (PNG specification, annex D).
void set_png_size(std::vector<std::byte>& bytes, std::uint32_t width, std::uint32_t height) {
  constexpr std::size_t kType = 12, kWidthAt = 16, kHeightAt = 20, kCrcAt = 29;
  const auto put = [&](std::size_t at, std::uint32_t value) {
    for (std::size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<std::byte>(value >> (24 - 8 * i) & 0xFF);
  };
  put(kWidthAt, width);
  put(kHeightAt, height);
  std::uint32_t crc = 0xFFFFFFFF;
  for (std::size_t i = kType; i < kCrcAt; ++i) {
    crc ^= std::to_integer<std::uint32_t>(bytes[i]);
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1) != 0 ? 0xEDB88320 ^ (crc >> 1) : crc >> 1;
  }
  put(kCrcAt, ~crc);
}

TEST(DepthPng, KeepsRawValues) {
  const auto raw = decode_depth_png(depth_png(), {});
  ASSERT_TRUE(raw) << raw.error().text();
  EXPECT_EQ(*raw, Image<std::uint16_t>(kWidth, kHeight, 1234));
}

TEST(DepthPng, IsRefusedWhenCutAtAnyByte) {
  const auto whole = depth_png();
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_FALSE(decode_depth_png(std::span(whole).first(size), {})) << "cut at " << size;
  }
}

TEST(DepthPng, IsRefusedWhenAnyByteIsWrong) {
  const auto whole = depth_png();
  for (std::size_t i = 0; i < whole.size(); ++i) {
    auto bytes = whole;
    bytes[i] ^= std::byte{0x10};
    EXPECT_FALSE(decode_depth_png(bytes, {})) << "byte " << i;
  }
}

TEST(DepthPng, OfEightBitsIsRefusedWithWhatWasExpected) {
  const TemporaryFolder folder;
  write_grey8(folder / "d.png", 7);
  const auto raw = decode_depth_png(bytes_of(folder / "d.png"), {});
  ASSERT_FALSE(raw);
  EXPECT_NE(raw.error().message.find("8-bit grey PNG; expected depth as a 16-bit grey PNG"), std::string::npos);
}

TEST(DepthPng, OfColourIsRefused) {
  EXPECT_FALSE(decode_depth_png(colour_file("c.png"), {}));
}

TEST(DepthPng, OfAbsurdSizeIsRefusedByItsHeader) {
  auto bytes = depth_png();
  set_png_size(bytes, 0x7FFFFFFF, 0x7FFFFFFF);  // 9 exabytes of depth
  const auto refused = decode_depth_png(bytes, {});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("2147483647 x 2147483647 pixels"), std::string::npos);
}

TEST(DepthPng, OfNoHeightIsRefused) {
  auto bytes = depth_png();
  set_png_size(bytes, kWidth, 0);
  EXPECT_FALSE(decode_depth_png(bytes, {}));
}

TEST(DepthPng, WithFewerRowsThanPromisedIsRefused) {
  auto bytes = depth_png();
  set_png_size(bytes, kWidth, 10 * kHeight);
  EXPECT_FALSE(decode_depth_png(bytes, {}));
}

TEST(ScaledDepth, HoldsMetresAndNoReturnForZeroAndSaturation) {
  Image<std::uint16_t> raw(4, 1);
  raw.at(0, 0) = 0;
  raw.at(1, 0) = 65535;
  raw.at(2, 0) = 5000;
  raw.at(3, 0) = 65534;
  const DepthImage depth_m = scale_depth(raw, 5000);
  EXPECT_EQ(depth_m.at(0, 0), 0.0F);
  EXPECT_EQ(depth_m.at(1, 0), 0.0F);
  EXPECT_EQ(depth_m.at(2, 0), 1.0F);
  EXPECT_FLOAT_EQ(depth_m.at(3, 0), 13.1068F);
}

TEST(ColourPicture, IsReadFromPng) {
  const auto colour = decode_picture(colour_file("c.png"), {});
  ASSERT_TRUE(colour) << colour.error().text();
  EXPECT_EQ(colour->at(3, 5), (Rgb8{200, 100, 50}));
}

TEST(ColourPicture, IsReadFromJpeg) {
  constexpr int kJpegError = 4;  // rounding of YCbCr and of the DCT
  const auto colour = decode_picture(colour_file("c.jpg"), {});
  ASSERT_TRUE(colour) << colour.error().text();
  EXPECT_NEAR(colour->at(3, 5).r, 200, kJpegError);
  EXPECT_NEAR(colour->at(3, 5).g, 100, kJpegError);
  EXPECT_NEAR(colour->at(3, 5).b, 50, kJpegError);
}

TEST(ColourPicture, IsRefusedWhenJpegIsCutAtAnyByte) {
  const auto whole = colour_file("c.jpg");
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_FALSE(decode_picture(std::span(whole).first(size), {})) << "cut at " << size;
  }
}

TEST(ColourPicture, OfNeitherFormatIsRefused) {
  const std::vector<std::byte> bytes(100, std::byte{'x'});
  const auto colour = decode_picture(bytes, {});
  ASSERT_FALSE(colour);
  EXPECT_EQ(colour.error().message, "neither a PNG nor a JPEG file");
}

TEST(ColourPicture, BeyondTheLimitIsRefusedByItsJpegHeader) {
  Limits limits;
  limits.max_image_pixels = 255;
  const auto refused = check_jpeg(colour_file("c.jpg"), limits);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("16 x 16"), std::string::npos);
}

TEST(Undistortion, WithoutDistortionChangesNothing) {
  DepthImage depth_m(8, 6);
  for (std::size_t i = 0; i < depth_m.size(); ++i) depth_m.pixels()[i] = static_cast<float>(i + 1);
  EXPECT_EQ(undistort(depth_m, {8, 6, 100, 100, 3.5, 2.5}, Distortion{}), depth_m);
}

TEST(Undistortion, FetchesEachPixelFromWhereTheLensPutIt) {
  // k1 alone: the ideal pixel at x = 0.1 is seen at x (1 + k1 x^2) = 0.1 * 1.5 = 0.15, in pixels 15 beside the centre.
  const CameraIntrinsics camera{41, 1, 100, 100, 20, 0};
  const Distortion distortion{50, 0, 0, 0, 0};
  EXPECT_NEAR(distort_pixel(30, 0, camera, distortion).x(), 35, 1e-12);
  DepthImage bent(41, 1);
  bent.at(35, 0) = 2.0F;
  EXPECT_EQ(undistort(bent, camera, distortion).at(30, 0), 2.0F);
}

TEST(Undistortion, TakesEachPictureForThatOfItsOwnCameraAndLens) {
  DepthImage bent(16, 12);
  for (std::size_t i = 0; i < bent.size(); ++i) bent.pixels()[i] = static_cast<float>(i + 1);
  const std::array cameras = {CameraIntrinsics{16, 12, 20, 20, 7.5, 5.5}, CameraIntrinsics{16, 12, 20, 20, 6.5, 5.5}};
  const std::array lenses = {Distortion{0.3, 0, 0, 0, 0}, Distortion{-0.2, 0, 0, 0, 0}};
  for (int round = 0; round < 2; ++round) {  // the second finds what the first has left
    for (const CameraIntrinsics& camera : cameras) {
      for (const Distortion& lens : lenses) {
        DepthImage expected(16, 12);
        for (int y = 0; y < 12; ++y) {
          for (int x = 0; x < 16; ++x) {
            const Eigen::Vector2d at = distort_pixel(x, y, camera, lens);
            const long u = std::lround(at.x()), v = std::lround(at.y());
            if (u >= 0 && v >= 0 && u < 16 && v < 12)
              expected.at(x, y) = bent.at(static_cast<int>(u), static_cast<int>(v));
          }
        }
        EXPECT_EQ(undistort(bent, camera, lens), expected) << round;
      }
    }
  }
}

}  // namespace
}  // namespace scanknit::test
