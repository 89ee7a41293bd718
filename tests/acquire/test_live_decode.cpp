// From a scanner's bytes to frames: colours, sizes, and which colour picture belongs to which depth picture.
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "acquire/raw/raw_decode.h"
#include "acquire/replay/frame_pairing.h"
#include "acquire/replay/undistort.h"
#include "raw_frames.h"

namespace scanknit::test {
namespace {

RawFrame picture(PixelFormat format, int width, int height, std::vector<int> values) {
  RawFrame frame;
  frame.profile = {StreamKind::kColour, format, width, height, 30};
  std::vector<std::byte> bytes;
  for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
  frame.bytes = share(std::move(bytes));
  return frame;
}

std::vector<Rgb8> colours(const RawFrame& frame) {
  const auto image = decode_raw_colour(frame, {});
  if (!image) return {};
  return {image->pixels().begin(), image->pixels().end()};
}

TEST(RawDepth, IsMetresByTheUnit) {
  RawFrame frame = picture(PixelFormat::kZ16, 2, 2, {0xE8, 0x03, 0, 0, 0xFF, 0xFF, 0x10, 0x27});
  const auto depth_m = decode_raw_depth(frame, 0.001, {});
  ASSERT_TRUE(depth_m);
  EXPECT_EQ(depth_m->at(0, 0), 1.0F);
  EXPECT_EQ(depth_m->at(1, 0), 0.0F);
  EXPECT_EQ(depth_m->at(0, 1), 0.0F) << "65535 is no return";
  EXPECT_EQ(depth_m->at(1, 1), 10.0F);
  EXPECT_EQ(decode_raw_depth(frame, 0.0001, {})->at(1, 1), 1.0F);
}

TEST(RawDepth, OfAnotherSizeIsRefused) {
  RawFrame frame = depth_frame(0);
  auto bytes = *frame.bytes;
  bytes.pop_back();
  frame.bytes = share(bytes);
  EXPECT_FALSE(decode_raw_depth(frame, 0.001, {}));
  bytes.resize(bytes.size() + 2);
  frame.bytes = share(bytes);
  EXPECT_FALSE(decode_raw_depth(frame, 0.001, {}));
  frame.bytes = nullptr;
  EXPECT_FALSE(decode_raw_depth(frame, 0.001, {}));
}

// BT.601's corners: black 16, white 235, and red as (81, 90, 240).
TEST(RawColour, YuyvAndUyvyAreTheSameColours) {
  const std::vector<Rgb8> expected = {{0, 0, 0}, {255, 255, 255}, {255, 0, 0}, {255, 0, 0}};
  EXPECT_EQ(colours(picture(PixelFormat::kYuyv, 2, 2, {16, 128, 235, 128, 81, 90, 81, 240})), expected);
  EXPECT_EQ(colours(picture(PixelFormat::kUyvy, 2, 2, {128, 16, 128, 235, 90, 81, 240, 81})), expected);
}

TEST(RawColour, RgbAndBgrAreTheSameColours) {
  const std::vector<Rgb8> expected = {{1, 2, 3}, {4, 5, 6}};
  EXPECT_EQ(colours(picture(PixelFormat::kRgb8, 2, 1, {1, 2, 3, 4, 5, 6})), expected);
  EXPECT_EQ(colours(picture(PixelFormat::kBgr8, 2, 1, {3, 2, 1, 6, 5, 4})), expected);
}

TEST(RawColour, OfAnOddWidthCannotBeYuyv) {
  EXPECT_FALSE(decode_raw_colour(picture(PixelFormat::kYuyv, 3, 1, {0, 0, 0, 0, 0, 0}), {}));
}

TEST(RawPair, IsLeftAndRightByPixels) {
  const RawFrame pair = picture(PixelFormat::kY8i, 2, 2, {1, 11, 2, 12, 3, 13, 4, 14});
  const auto decoded = decode_raw_pair(pair, {});
  ASSERT_TRUE(decoded) << decoded.error().text();
  for (std::uint8_t i = 0; i < 4; ++i) {
    const auto left = static_cast<std::uint8_t>(1 + i), right = static_cast<std::uint8_t>(11 + i);
    EXPECT_EQ(decoded->left.pixels()[i], (Rgb8{left, left, left}));
    EXPECT_EQ(decoded->right.pixels()[i], (Rgb8{right, right, right}));
  }
  EXPECT_FALSE(decode_raw_pair(picture(PixelFormat::kY8i, 2, 2, {1, 2, 3, 4, 5, 6, 7}), {}));
  EXPECT_FALSE(decode_raw_pair(picture(PixelFormat::kZ16, 1, 1, {1, 2}), {}));
  EXPECT_FALSE(decode_raw_colour(pair, {}));
  EXPECT_FALSE(decode_raw_depth(pair, 0.001, {}));
}

std::vector<std::byte> jpeg_bytes(int width, int height) {
  std::vector<unsigned char> encoded;
  cv::imencode(".jpg", cv::Mat(height, width, CV_8UC3, cv::Scalar(30, 120, 210)), encoded);
  const auto bytes = std::as_bytes(std::span(encoded));
  return {bytes.begin(), bytes.end()};
}

RawFrame jpeg_frame(std::vector<std::byte> bytes, int width, int height) {
  RawFrame frame;
  frame.profile = {StreamKind::kColour, PixelFormat::kMjpeg, width, height, 30};
  frame.bytes = share(std::move(bytes));
  return frame;
}

// UVC cameras leave out the tables that everybody knows (JPEG annex K.3).
std::vector<std::byte> without_huffman_tables(const std::vector<std::byte>& jpeg) {
  std::vector<std::byte> bytes(jpeg.begin(), jpeg.begin() + 2);
  std::size_t at = 2;
  while (jpeg[at + 1] != std::byte{0xDA}) {
    const std::size_t length =
        2 + std::to_integer<std::size_t>(jpeg[at + 2]) * 256 + std::to_integer<std::size_t>(jpeg[at + 3]);
    const auto begin = jpeg.begin() + static_cast<std::ptrdiff_t>(at);
    if (jpeg[at + 1] != std::byte{0xC4}) bytes.insert(bytes.end(), begin, begin + static_cast<std::ptrdiff_t>(length));
    at += length;
  }
  bytes.insert(bytes.end(), jpeg.begin() + static_cast<std::ptrdiff_t>(at), jpeg.end());
  return bytes;
}

TEST(RawColour, MjpegNeedsNoHuffmanTables) {
  const auto whole = jpeg_bytes(32, 16);
  const auto bare = without_huffman_tables(whole);
  ASSERT_LT(bare.size(), whole.size());
  const auto expected = colours(jpeg_frame(whole, 32, 16));
  ASSERT_EQ(expected.size(), 32u * 16u);
  EXPECT_NEAR(expected[0].r, 210, 3);
  EXPECT_EQ(colours(jpeg_frame(bare, 32, 16)), expected);
}

TEST(RawColour, MjpegOfAnotherSizeThanItsStreamIsRefused) {
  EXPECT_FALSE(decode_raw_colour(jpeg_frame(jpeg_bytes(32, 16), 16, 32), {}));
}

TEST(RawColour, MjpegCutAtAnyByteIsRefused) {
  const auto whole = jpeg_bytes(16, 16);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const std::vector<std::byte> cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_FALSE(decode_raw_colour(jpeg_frame(cut, 16, 16), {})) << size << " bytes";
  }
}

TEST(RawFrameDecoding, GivesBothCamerasAndTheWayBetween) {
  const RawCalibration calibration = raw_calibration();
  const RawFrame colour = colour_frame(3);
  const auto frame = decode_raw_frame(depth_frame(3), &colour, calibration, {});
  ASSERT_TRUE(frame) << frame.error().text();
  EXPECT_EQ(frame->sequence, 3u);
  EXPECT_EQ(frame->timestamp_ns, depth_frame(3).device_ns);
  EXPECT_EQ(frame->intrinsics, calibration.depth.intrinsics);
  EXPECT_EQ(frame->colour->intrinsics, calibration.colour.intrinsics);
  EXPECT_EQ(frame->colour->T_colour_depth.matrix(), calibration.T_colour_depth.matrix());
}

TEST(RawFrameDecoding, StraightensWhatEachLensBent) {
  RawCalibration calibration = raw_calibration();
  calibration.depth.distortion = {0.1, -0.05, 0.001, 0.002, 0};
  calibration.colour.distortion = {-0.2, 0.03, 0, 0, 0};
  const RawFrame colour = colour_frame(0);
  const auto frame = decode_raw_frame(depth_frame(0), &colour, calibration, {});
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->depth_m, undistort(*decode_raw_depth(depth_frame(0), 0.001, {}), calibration.depth.intrinsics,
                                      calibration.depth.distortion));
  EXPECT_EQ(frame->colour->image,
            undistort(*decode_raw_colour(colour, {}), calibration.colour.intrinsics, calibration.colour.distortion));
}

TEST(RawFrameDecoding, RefusesAPictureThatIsNotItsCameras) {
  EXPECT_FALSE(decode_raw_frame(depth_frame(0, 32, 24), nullptr, raw_calibration(), {}));
  RawCalibration unknown = raw_calibration();
  unknown.depth = {};
  EXPECT_FALSE(decode_raw_frame(depth_frame(0), nullptr, unknown, {}));
}

TEST(RawFrameDecoding, WithoutAColourCameraTakesColourToBeRegistered) {
  RawCalibration calibration = raw_calibration();
  calibration.colour = {};
  const RawFrame colour = colour_frame(0);
  const auto frame = decode_raw_frame(depth_frame(0), &colour, calibration, {});
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->colour->intrinsics, calibration.depth.intrinsics.resized(32, 24));
  EXPECT_TRUE(frame->colour->T_colour_depth.isApprox(Pose::Identity()));
}

TEST(NearestInTime, TakesTheEarlierOfTwoEquallyNear) {
  const std::vector<std::int64_t> times = {0, 100, 200};
  EXPECT_EQ(nearest_in_time(times, 150, 50), 1u);
  EXPECT_EQ(nearest_in_time(times, 151, 50), 2u);
  EXPECT_EQ(nearest_in_time(times, -50, 50), 0u);
  EXPECT_EQ(nearest_in_time(times, -51, 50), std::nullopt);
  EXPECT_EQ(nearest_in_time(times, 251, 50), std::nullopt);
  EXPECT_EQ(nearest_in_time({}, 0, 50), std::nullopt);
}

TEST(NearestInTime, SurvivesTheLongestDistance) {
  const std::vector<std::int64_t> times = {std::numeric_limits<std::int64_t>::min()};
  EXPECT_EQ(nearest_in_time(times, std::numeric_limits<std::int64_t>::max(), 50), std::nullopt);
}

// Sequence numbers of the pairs that can be had; -1: no colour.
std::vector<std::pair<int, int>> take_pairs(FramePairing& pairing, bool is_end = false) {
  std::vector<std::pair<int, int>> pairs;
  while (const auto pair = is_end ? pairing.next_at_end() : pairing.next()) {
    pairs.emplace_back(static_cast<int>(pair->depth.sequence),
                       pair->colour ? static_cast<int>(pair->colour->sequence) : -1);
  }
  return pairs;
}

using Pairs = std::vector<std::pair<int, int>>;

TEST(FramePairing, WaitsForTheColourThatIsYetToCome) {
  FramePairing pairing(true);
  pairing.add(depth_frame(0));
  EXPECT_EQ(take_pairs(pairing), Pairs{});
  pairing.add(colour_frame(0));
  EXPECT_EQ(take_pairs(pairing), (Pairs{{0, 0}}));
}

TEST(FramePairing, TakesTheNearestOfBeforeAndAfter) {
  FramePairing pairing(true);
  pairing.add(colour_frame(0, -2'000'000));
  pairing.add(depth_frame(0));
  pairing.add(colour_frame(0, 1'000'000));
  EXPECT_EQ(take_pairs(pairing), (Pairs{{0, 0}}));
  pairing.add(depth_frame(1));
  pairing.add(colour_frame(1, -3'000'000));
  pairing.add(colour_frame(2, 0));
  EXPECT_EQ(take_pairs(pairing), (Pairs{{1, 1}}));
}

TEST(FramePairing, WithoutAColourStreamWaitsForNothing) {
  FramePairing pairing(false);
  pairing.add(depth_frame(0));
  EXPECT_EQ(take_pairs(pairing), (Pairs{{0, -1}}));
}

TEST(FramePairing, GoesOnWithoutColourThatDoesNotCome) {
  FramePairing pairing(true);
  pairing.add(colour_frame(0));
  for (std::uint32_t i = 0; i < 6; ++i) pairing.add(depth_frame(i));
  EXPECT_EQ(take_pairs(pairing), (Pairs{{0, 0}, {1, -1}, {2, -1}, {3, -1}}));
  EXPECT_EQ(take_pairs(pairing, true), (Pairs{{4, -1}, {5, -1}}));
}

TEST(FramePairing, OneColourPictureServesSeveralDepthPictures) {
  FramePairing pairing(true);
  for (std::uint32_t i = 0; i < 3; ++i) {
    RawFrame depth = depth_frame(i);
    depth.device_ns = 5'000'000'000 + i * 11'111'111;  // 90 a second
    pairing.add(depth);
  }
  pairing.add(colour_frame(0, 11'000'000));
  EXPECT_EQ(take_pairs(pairing, true), (Pairs{{0, 0}, {1, 0}, {2, 0}}));
}

}  // namespace
}  // namespace scanknit::test
