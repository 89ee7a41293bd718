// Bags of ROS 2: messages in CDR, topics, frames of reference, and what damage does.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <iomanip>
#include <limits>
#include <sstream>

#include "acquire/raw/raw_recording.h"
#include "acquire/ros2/ros2_messages.h"
#include "acquire/ros2/transform_tree.h"
#include "core/picture/jpeg_codec.h"
#include "core/picture/png_codec.h"
#include "robot_frames.h"
#include "ros2_bag.h"
#include "rvl_writer.h"
#include "test_replay_support.h"
#include "tests/support/text.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;
using Reasons = std::vector<std::string>;

Bytes as_bytes(const std::vector<std::uint8_t>& values) {
  const auto bytes = std::as_bytes(std::span(values));
  return {bytes.begin(), bytes.end()};
}

AcquireConfig still() {
  AcquireConfig config;
  config.poses = PoseMode::kStill;
  return config;
}

class Ros2 : public ::testing::Test {
 protected:
  void write(const Bytes& bytes) const { write_bytes(folder_ / "bag_0.mcap", bytes); }
  /// Depth of frame "d", whose camera is known, at the time 1.
  [[nodiscard]] Ros2Bag with_one_picture() const {
    Ros2Bag bag;
    bag.add("/d/camera_info", kCameraType, 0, ros_.camera(4, 2, {4, 4, 1.5, 0.5}));
    bag.add("/d/image", kImageType, 1, ros_.image(1, "d", "16UC1", 4, 2, counted_depth(1000, 8)));
    return bag;
  }
  [[nodiscard]] Played played(const Ros2Bag& bag, const AcquireConfig& config = {}) const {
    write(bag.file());
    return play(folder_ / "bag_0.mcap", config);
  }
  [[nodiscard]] RecordingInfo described(const Ros2Bag& bag) const {
    write(bag.file());
    const auto source = open_recording(folder_ / "bag_0.mcap", {});
    EXPECT_TRUE(source) << source.error().text();
    return source ? (*source)->info() : RecordingInfo{};
  }
  [[nodiscard]] std::string refused(const Ros2Bag& bag) const {
    write(bag.file());
    return open_error(folder_ / "bag_0.mcap");
  }

  TemporaryFolder folder_;
  Ros2Writer ros_;
};

struct Kind {
  bool is_little;
  BagPacking packing;
  const char* name;
};
std::ostream& operator<<(std::ostream& out, const Kind& kind) {
  return out << kind.name;
}

class Ros2File : public ::testing::TestWithParam<Kind> {};

TEST_P(Ros2File, GivesFramesWithCamerasAndPoses) {
  const TemporaryFolder folder;
  write_bytes(folder / "bag/bag_0.mcap", robot_bag(GetParam().is_little).file(GetParam().packing));
  write_text(folder / "bag/metadata.yaml", "rosbag2_bagfile_information:\n");
  expect_robot(play(folder / "bag"));
}

/// How many frames of a file in memory can be decoded; `warning`: the recording's first, where it can be opened.
std::size_t frames_in(const Bytes& file, std::string& warning) {
  const auto recording = index_ros2(std::make_unique<MemoryAccess>(file), "bag.mcap", {});
  if (!recording) return 0;
  warning = recording->warnings.empty() ? "none" : recording->warnings.front();
  const auto is_whole = [&](const FrameEntry& entry) {
    return std::holds_alternative<DecodedFrame>(recording->decode(entry, {}));
  };
  const auto& entries = recording->entries;
  return static_cast<std::size_t>(std::count_if(entries.begin(), entries.end(), is_whole));
}

TEST_P(Ros2File, CutAtAnyByteGivesWhatIsWhole) {
  const Bytes whole = robot_bag(GetParam().is_little).file(GetParam().packing);
  std::size_t before = 0;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    std::string warning = "the bag is torn";
    const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    const std::size_t frames = frames_in(cut, warning);
    ASSERT_GE(frames, before) << size;
    before = frames;
    EXPECT_TRUE(contains(warning, "the bag is torn")) << size;
  }
  EXPECT_EQ(before, 2u);
}

TEST_P(Ros2File, SurvivesAnyWrongByte) {
  const Bytes whole = robot_bag(GetParam().is_little).file(GetParam().packing);
  std::string warning;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    for (const int change : {0x01, 0xFF}) {
      Bytes damaged = whole;
      damaged[i] ^= static_cast<std::byte>(change);
      EXPECT_LE(frames_in(damaged, warning), 2u);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(AllKinds, Ros2File,
                         ::testing::Values(Kind{true, BagPacking::kChunk, "plain"},
                                           Kind{true, BagPacking::kZstd, "zstd"}, Kind{true, BagPacking::kLz4, "lz4"},
                                           Kind{true, BagPacking::kNoChunk, "no_chunk"},
                                           Kind{false, BagPacking::kChunk, "big_endian"}),
                         [](const auto& kind) { return std::string(kind.param.name); });

TEST_F(Ros2, SaysWhichTopicsAreRead) {
  Ros2Bag bag = robot_bag();
  bag.add("/cam/infra1/image_raw", kImageType, 7, ros_.image(7, "depth_link", "mono16", 4, 2, counted_depth(0, 8)));
  bag.add("/scan", "sensor_msgs/msg/LaserScan", 7, {});
  const RecordingInfo info = described(bag);
  EXPECT_EQ(info.format, "ros2");
  EXPECT_EQ(info.topics, (std::map<std::string, std::string>{{"depth", "/cam/depth/image_raw"},
                                                             {"colour", "/cam/color/image_raw"},
                                                             {"poses", "tf: map from depth_link"},
                                                             {"not_read", "/cam/infra1/image_raw"}}));
  EXPECT_EQ(info.frames_with_pose, 2u);
  EXPECT_EQ(info.world_up, UpAxis::kZ);
  EXPECT_TRUE(info.warnings.empty());
}

TEST_F(Ros2, IsKnownWithoutTheProfileOfItsWriter) {
  write(robot_bag().file(BagPacking::kChunk, ""));
  expect_robot(play(folder_ / "bag_0.mcap"));
}

TEST_F(Ros2, TakesDepthWithACameraAndTheMostPictures) {
  Ros2Bag bag = robot_bag();
  for (std::int64_t i = 0; i < 5; ++i) {
    bag.add("/a/depth/image_raw", kImageType, i, ros_.image(i, "a", "16UC1", 4, 2, counted_depth(1, 8)));
  }
  EXPECT_EQ(described(bag).topics.at("depth"), "/cam/depth/image_raw") << "/a has no camera_info";
  bag.add("/a/depth/camera_info", kCameraType, 9, ros_.camera(4, 2, {4, 4, 1.5, 0.5}));
  EXPECT_EQ(described(bag).topics.at("depth"), "/cam/depth/image_raw") << "nobody knows where /a is beside colour";
  bag.add("/tf_static", kTransformType, 5, ros_.transform(0, "base", "a", {0, 0, 1, 0, 0, 0, 1}));
  EXPECT_EQ(described(bag).topics.at("depth"), "/a/depth/image_raw");
}

// A phone that focuses: each picture has the camera that holds at its time, the first one also before.
TEST_F(Ros2, FollowsACameraThatChanges) {
  Ros2Bag bag;
  bag.add("/d/camera_info", kCameraType, 20, ros_.camera(4, 2, {4, 4, 1.5, 0.5}));
  bag.add("/d/camera_info", kCameraType, 30, ros_.camera(4, 2, {4, 4, 1.5, 0.5}));
  bag.add("/d/camera_info", kCameraType, 40, ros_.camera(4, 2, {5, 5, 1.5, 0.5}));
  std::vector<double> focal_lengths;
  for (const std::int64_t time : {10, 20, 30, 40, 50}) {
    bag.add("/d/image", kImageType, time, ros_.image(time, "", "16UC1", 4, 2, counted_depth(1000, 8)));
  }
  for (const Frame& frame : played(bag, still()).frames) focal_lengths.push_back(frame.intrinsics.fx);
  EXPECT_EQ(focal_lengths, (std::vector<double>{4, 4, 4, 5, 5}));
}

TEST_F(Ros2, ReadsDepthOfAllKinds) {
  const auto depth_of = [&](const std::string& topic, const char* type, const Bytes& message) {
    Ros2Bag bag;
    bag.add("/d/camera_info", kCameraType, 0, ros_.camera(4, 2, {4, 4, 1.5, 0.5}));
    bag.add(topic, type, 1, message);
    return played(bag, still()).frames.at(0).depth_m;
  };
  const Bytes millimetres = counted_depth(1000, 8);
  EXPECT_EQ(depth_of("/d/image", kImageType, ros_.image(1, "", "mono16", 4, 2, millimetres)).at(3, 1), 1.007F);
  Bytes swapped = millimetres;
  for (std::size_t i = 0; i < swapped.size(); i += 2) std::swap(swapped[i], swapped[i + 1]);
  EXPECT_EQ(depth_of("/d/image", kImageType, ros_.image(1, "", "16UC1", 4, 2, swapped, true)).at(3, 1), 1.007F);
  Bytes padded = millimetres;
  padded.insert(padded.begin() + 8, 4, std::byte{0xFF});
  padded.insert(padded.end(), 4, std::byte{0xFF});
  EXPECT_EQ(depth_of("/d/image", kImageType, ros_.image(1, "", "16UC1", 4, 2, padded)).at(3, 1), 1.007F);
  Bytes metres;
  for (const float z : {0.5F, -1.0F, std::nanf(""), std::numeric_limits<float>::infinity(), 1.0F, 1.5F, 2.0F, 2.5F}) {
    ByteAppender(metres).little_endian(z);
  }
  const DepthImage of_floats = depth_of("/d/image", kImageType, ros_.image(1, "", "32FC1", 4, 2, metres));
  const auto pixels = of_floats.pixels();
  EXPECT_EQ(std::vector<float>(pixels.begin(), pixels.end()),
            (std::vector<float>{0.5F, 0, 0, 0, 1.0F, 1.5F, 2.0F, 2.5F}));
}

TEST_F(Ros2, ReadsCompressedDepth) {
  Image<std::uint16_t> raw(4, 2);
  for (std::size_t i = 0; i < raw.size(); ++i) raw.pixels()[i] = static_cast<std::uint16_t>(i * 100);
  const auto depth_of = [&](const char* format) {
    Bytes data;
    ByteAppender(data).little_endian(std::int32_t{0});
    ByteAppender(data).little_endian(200.0F);
    ByteAppender(data).little_endian(20.0F);
    ByteAppender(data).append(as_bytes(encode_png(raw, PngEffort::kMedium).value()));
    Ros2Bag bag;
    bag.add("/d/camera_info", kCameraType, 0, ros_.camera(4, 2, {4, 4, 1.5, 0.5}));
    bag.add("/d/image/compressedDepth", kCompressedType, 1, ros_.compressed(1, "d", format, data));
    return played(bag, still()).frames.at(0).depth_m;
  };
  EXPECT_EQ(depth_of("16UC1; compressedDepth").at(3, 1), 0.7F);
  EXPECT_EQ(depth_of("32FC1; compressedDepth png").at(1, 0), 200.0F / (100.0F - 20.0F)) << "an inverse";
  EXPECT_EQ(depth_of("32FC1; compressedDepth png").at(0, 0), 0.0F);
}

TEST_F(Ros2, ReadsDepthThatRvlCompressed) {
  Image<std::uint16_t> raw(4, 2);
  for (std::size_t i = 0; i < raw.size(); ++i) raw.pixels()[i] = static_cast<std::uint16_t>(i * 100);
  const auto played_of = [&](const char* format, std::uint32_t width, std::size_t cut = 0) {
    Bytes data;
    ByteAppender(data).little_endian(std::int32_t{0});
    ByteAppender(data).little_endian(200.0F);
    ByteAppender(data).little_endian(20.0F);
    ByteAppender(data).little_endian(width);
    ByteAppender(data).little_endian(std::uint32_t{2});
    ByteAppender(data).append(RvlWriter(raw.pixels()).bytes());
    data.resize(data.size() - cut);
    Ros2Bag bag;
    bag.add("/d/camera_info", kCameraType, 0, ros_.camera(4, 2, {4, 4, 1.5, 0.5}));
    bag.add("/d/image/compressedDepth", kCompressedType, 1, ros_.compressed(1, "d", format, data));
    return played(bag, still());
  };
  EXPECT_EQ(played_of("16UC1; compressedDepth rvl", 4).frames.at(0).depth_m.at(3, 1), 0.7F);
  EXPECT_EQ(played_of("32FC1; compressedDepth rvl", 4).frames.at(0).depth_m.at(1, 0), 200.0F / (100.0F - 20.0F));
  for (const auto& torn :
       {played_of("16UC1; compressedDepth rvl", 4, 4), played_of("16UC1; compressedDepth rvl", 4, 14),
        played_of("16UC1; compressedDepth rvl", 0x80000000)}) {
    EXPECT_TRUE(torn.frames.empty());
    EXPECT_EQ(torn.dropped.size(), 1u);
  }
}

TEST_F(Ros2, ReadsColourOfAllKinds) {
  const auto colour_of = [&](const std::string& topic, const char* type, const Bytes& message) {
    Ros2Bag bag;
    bag.add("/d/camera_info", kCameraType, 0, ros_.camera(1, 1, {4, 4, 0, 0}));
    bag.add("/d/image", kImageType, 1, ros_.image(1, "d", "16UC1", 1, 1, counted_depth(1000, 1)));
    bag.add(topic, type, 1, message);
    return played(bag, still()).frames.at(0).colour.value();
  };
  const auto pixel = [&](const char* encoding, const std::vector<std::uint8_t>& values) {
    return colour_of("/c/image", kImageType, ros_.image(1, "d", encoding, 1, 1, as_bytes(values))).image.at(0, 0);
  };
  EXPECT_EQ(pixel("rgb8", {1, 2, 3}), (Rgb8{1, 2, 3}));
  EXPECT_EQ(pixel("bgr8", {1, 2, 3}), (Rgb8{3, 2, 1}));
  EXPECT_EQ(pixel("rgba8", {1, 2, 3, 4}), (Rgb8{1, 2, 3}));
  EXPECT_EQ(pixel("bgra8", {1, 2, 3, 4}), (Rgb8{3, 2, 1}));
  EXPECT_EQ(pixel("mono8", {9}), (Rgb8{9, 9, 9}));
  const auto pair = [&](const char* encoding, const std::vector<std::uint8_t>& values) {
    return colour_of("/c/image", kImageType, ros_.image(1, "d", encoding, 2, 1, as_bytes(values))).image;
  };
  const Rgb8 red{255, 0, 0};  // Y 81, U 90, V 240 in BT.601
  for (const char* encoding : {"yuv422", "uyvy"}) {
    EXPECT_EQ(pair(encoding, {90, 81, 240, 16}).at(0, 0), red) << encoding;
    EXPECT_EQ(pair(encoding, {128, 16, 128, 235}).at(1, 0), (Rgb8{255, 255, 255})) << encoding;
  }
  for (const char* encoding : {"yuv422_yuy2", "yuyv"}) EXPECT_EQ(pair(encoding, {81, 90, 16, 240}).at(0, 0), red);
  ColourImage picture(2, 2);
  picture.at(1, 1) = {200, 100, 50};
  const Bytes png = as_bytes(encode_png(picture, PngEffort::kMedium).value());
  const auto of_png =
      colour_of("/c/image/compressed", kCompressedType, ros_.compressed(1, "d", "rgb8; png compressed", png));
  EXPECT_EQ(of_png.image.at(1, 1), (Rgb8{200, 100, 50}));
  EXPECT_EQ(*of_png.encoded, png) << "a conversion keeps the file";
  const Bytes jpeg = as_bytes(encode_jpeg(picture, 95).value());
  EXPECT_EQ(*colour_of("/c/image/compressed", kCompressedType, ros_.compressed(1, "d", "jpeg", jpeg)).encoded, jpeg);
}

TEST_F(Ros2, FillsInTheColoursOfABayerMosaic) {
  const auto colours_of = [&](const char* encoding, const std::vector<std::uint8_t>& values) {
    Ros2Bag bag;
    bag.add("/d/camera_info", kCameraType, 0, ros_.camera(1, 1, {4, 4, 0, 0}));
    bag.add("/d/image", kImageType, 1, ros_.image(1, "d", "16UC1", 1, 1, counted_depth(1000, 1)));
    bag.add("/c/image", kImageType, 1, ros_.image(1, "d", encoding, 4, 3, as_bytes(values)));
    return played(bag, still()).frames.at(0).colour.value().image;
  };
  const auto of_squares = [&](const char* encoding, const std::array<std::uint8_t, 4>& square) {
    std::vector<std::uint8_t> values;
    for (std::size_t i = 0; i < 12; ++i) values.push_back(square[2 * (i / 4 % 2) + i % 2]);
    return colours_of(encoding, values);
  };
  for (const auto& picture :
       {of_squares("bayer_rggb8", {200, 100, 100, 50}), of_squares("bayer_bggr8", {50, 100, 100, 200}),
        of_squares("bayer_gbrg8", {100, 50, 200, 100}), of_squares("bayer_grbg8", {100, 200, 50, 100})}) {
    for (const Rgb8& pixel : picture.pixels()) EXPECT_EQ(pixel, (Rgb8{200, 100, 50}));
  }
  // R10 G20 R30 G40 / G50 B60 G70 B80 / R90 G100 R110 G120
  const auto picture = colours_of("bayer_rggb8", {10, 20, 30, 40, 50, 60, 70, 80, 90, 100, 110, 120});
  EXPECT_EQ(picture.at(0, 0), (Rgb8{10, 35, 60}));
  EXPECT_EQ(picture.at(1, 1), (Rgb8{60, 60, 60}));
  EXPECT_EQ(picture.at(2, 1), (Rgb8{70, 70, 70}));
}

TEST_F(Ros2, StraightensBothKindsOfLens) {
  constexpr std::uint32_t kSide = 16;
  const CameraIntrinsics camera{kSide, kSide, 16, 16, 7.5, 7.5};
  const auto played_with = [&](const char* topic, const char* lens, const std::vector<double>& d) {
    Ros2Bag bag;
    bag.add("/d/camera_info", kCameraType, 0, ros_.camera(kSide, kSide, {16, 16, 7.5, 7.5}, lens, d));
    bag.add(topic, kImageType, 1, ros_.image(1, "d", "16UC1", kSide, kSide, counted_depth(1000, kSide * kSide)));
    return played(bag, still()).frames.at(0);
  };
  const DepthImage bent = played_with("/d/image_raw", "plumb_bob", {0, 0, 0, 0, 0}).depth_m;
  const Distortion plumb_bob = {0.3, -0.1, 0.01, 0.02, 0.05};
  EXPECT_EQ(played_with("/d/image_raw", "plumb_bob", {0.3, -0.1, 0.01, 0.02, 0.05}).depth_m,
            undistort(bent, camera, plumb_bob));
  const RationalDistortion rational = {0.5, -0.1, 0.01, 0.02, 0.05, 0.1, -0.2, 0.3};
  const DepthImage straight = undistort(bent, camera, rational);
  EXPECT_NE(straight, undistort(bent, camera, Distortion{0.5, -0.1, 0.01, 0.02, 0.05}));
  EXPECT_EQ(played_with("/d/image_raw", "rational_polynomial", {rational.begin(), rational.end()}).depth_m, straight);
  const FisheyeDistortion fisheye = {{0.1, -0.05, 0.02, 0.01}};
  const DepthImage of_fisheye = undistort(bent, camera, fisheye);
  EXPECT_NE(of_fisheye, bent);
  EXPECT_EQ(played_with("/d/image_raw", "equidistant", {0.1, -0.05, 0.02, 0.01}).depth_m, of_fisheye);
  EXPECT_EQ(played_with("/d/image_raw", "equidistant", {}).depth_m, undistort(bent, camera, FisheyeDistortion{}));
  const Frame rectified = played_with("/d/image_rect_raw", "plumb_bob", {0.3, -0.1, 0.01, 0.02, 0.05});
  EXPECT_EQ(rectified.depth_m, bent) << "straight already";
  EXPECT_EQ(rectified.intrinsics.fx, 32) << "the matrix P";
}

TEST(FisheyeLens, BendsAsKannalaAndBrandtSay) {
  const CameraIntrinsics camera{100, 100, 50, 40, 49.5, 49.5};
  const double angle = std::atan(0.6);  // of the ray through 30 pixels beside the middle
  const Eigen::Vector2d plain = distort_pixel(49.5 + 30, 49.5, camera, FisheyeDistortion{});
  EXPECT_NEAR(plain.x(), 49.5 + 50 * angle, 1e-12);
  EXPECT_NEAR(plain.y(), 49.5, 1e-12);
  const double bent = angle * (1 + 0.1 * std::pow(angle, 2) - 0.2 * std::pow(angle, 4) + 0.3 * std::pow(angle, 6) -
                               0.4 * std::pow(angle, 8));
  EXPECT_NEAR(distort_pixel(49.5 + 30, 49.5, camera, FisheyeDistortion{{0.1, -0.2, 0.3, -0.4}}).x(), 49.5 + 50 * bent,
              1e-12);
  EXPECT_EQ(distort_pixel(49.5, 49.5, camera, FisheyeDistortion{{1, 1, 1, 1}}), Eigen::Vector2d(49.5, 49.5));
}

TEST_F(Ros2, SaysWhenItCannotStraightenALens) {
  Ros2Bag bag;
  bag.add("/d/camera_info", kCameraType, 0, ros_.camera(4, 2, {4, 4, 1.5, 0.5}, "omnidirectional", {0.1, 0, 0, 0}));
  bag.add("/d/image_raw", kImageType, 1, ros_.image(1, "d", "16UC1", 4, 2, counted_depth(1000, 8)));
  EXPECT_EQ(described(bag).warnings.size(), 1u);
}

TEST_F(Ros2, NamesTheTopicThatShouldHaveTheCamera) {
  Ros2Bag bag;
  bag.add("/d/image_raw/compressedDepth", kCompressedType, 1,
          ros_.compressed(1, "d", "16UC1; compressedDepth", Bytes(13)));
  EXPECT_TRUE(contains(refused(bag), "CameraInfo on /d/camera_info; give it as acquire.intrinsics=")) << refused(bag);
  bag.add("/d/camera_info", kCameraType, 0, ros_.camera(4, 2, {0, 0, 0, 0}));
  EXPECT_TRUE(contains(refused(bag), "no usable sensor_msgs/CameraInfo")) << "not calibrated";
  EXPECT_FALSE(parse_camera_info(ros_.camera(4, 2, {4, 4, 1.5, 0.5}, "plumb_bob", {}, 2))) << "binning";
  AcquireConfig config = still();
  config.intrinsics = CameraModel{{4, 2, 4, 4, 1.5, 0.5}, {}};
  EXPECT_EQ(played(bag, config).reasons(), Reasons{"unreadable"}) << "opened, though its picture is no PNG";
}

TEST_F(Ros2, WithoutDepthListsItsTopics) {
  Ros2Bag bag;
  bag.add("/points", "sensor_msgs/msg/PointCloud2", 1, {});
  bag.add("/c/image", kImageType, 1, ros_.image(1, "c", "rgb8", 1, 1, Bytes(3)));
  EXPECT_TRUE(contains(refused(bag), "its topics: /c/image, /points")) << refused(bag);
}

TEST_F(Ros2, TakesOdometryWhereTfIsSilent) {
  Ros2Bag bag;
  bag.add("/d/camera_info", kCameraType, 0, ros_.camera(4, 2, {4, 4, 1.5, 0.5}));
  bag.add("/odom", "nav_msgs/msg/Odometry", 1, ros_.odometry(1000, "odom", "base", {1, 0, 0, 0, 0, 0, 1}));
  bag.add("/odom", "nav_msgs/msg/Odometry", 1, ros_.odometry(3000, "odom", "base", {3, 0, 0, 0, 0, 0, 1}));
  bag.add("/tf_static", kTransformType, 1, ros_.transform(0, "base", "d", {0, 0, 5, 0, 0, 0, 1}));
  bag.add("/d/image", kImageType, 1, ros_.image(2000, "d", "16UC1", 4, 2, counted_depth(1, 8)));
  EXPECT_TRUE(played(bag).frames.at(0).T_world_camera->translation().isApprox(Eigen::Vector3d(2, 0, 5)));
}

TEST_F(Ros2, TakesPosesOfTheCameraWhereTfIsSilentAndSaysSo) {
  Ros2Bag bag;
  bag.add("/d/camera_info", kCameraType, 0, ros_.camera(4, 2, {4, 4, 1.5, 0.5}));
  bag.add("/d/image", kImageType, 1, ros_.image(2000, "d", "16UC1", 4, 2, counted_depth(1, 8)));
  bag.add("/slam/pose", "geometry_msgs/msg/PoseStamped", 1, ros_.pose(2000, "map", {7, 8, 9, 0, 0, 0, 1}));
  EXPECT_TRUE(played(bag).frames.at(0).T_world_camera->translation().isApprox(Eigen::Vector3d(7, 8, 9)));
  const RecordingInfo info = described(bag);
  EXPECT_EQ(info.topics.at("poses"), "/slam/pose");
  ASSERT_EQ(info.warnings.size(), 1u);
  EXPECT_TRUE(contains(info.warnings[0], "the poses of /slam/pose are taken for the depth camera's"));
}

TEST_F(Ros2, HasNoPoseWhereTfPauses) {
  Ros2Bag bag = robot_bag();
  bag.add("/cam/depth/image_raw", kImageType, 3,
          ros_.image(1'200'000'000, "depth_link", "16UC1", 4, 2, counted_depth(1, 8)));
  EXPECT_EQ(played(bag).reasons(), Reasons{"no_pose"});
}

TEST_F(Ros2, SaysWhenItDoesNotKnowWhereColourIs) {
  Ros2Bag bag = with_one_picture();
  bag.add("/c/image", kImageType, 1, ros_.image(1, "c", "rgb8", 4, 2, Bytes(24)));
  ASSERT_EQ(described(bag).warnings.size(), 1u);
  EXPECT_TRUE(contains(described(bag).warnings[0], "tf does not say where 'c' is beside 'd'"));
}

TEST_F(Ros2, SaysThatTfMovesButDoesNotLeadToTheCamera) {
  Ros2Bag bag = with_one_picture();
  bag.add("/tf", kTransformType, 1, ros_.transform(1, "map", "base", {0, 0, 1, 0, 0, 0, 1}));
  ASSERT_EQ(described(bag).warnings.size(), 1u);
  EXPECT_EQ(described(bag).warnings[0],
            "tf moves (map -> base), but does not lead from there to depth's frame 'd': no poses are known. Record "
            "/tf_static, too, or name a topic of the camera's poses (acquire.topics.poses)");
}

TEST_F(Ros2, SaysThatNoPoseIsAtThePicturesTimes) {
  Ros2Bag bag = with_one_picture();
  bag.add("/tf", kTransformType, 1, ros_.transform(90'000'000'000, "map", "d", {0, 0, 1, 0, 0, 0, 1}));
  ASSERT_EQ(described(bag).warnings.size(), 1u);
  EXPECT_EQ(described(bag).warnings[0],
            "the bag has poses (tf: map from d), but none at the time of a depth picture, so that none is known. Do "
            "their stamps come from the same clock, ten times a second?");
}

TEST_F(Ros2, WhoseClockStepsBackLosesNeitherDepthNorColour) {
  Ros2Bag bag;
  bag.add("/d/camera_info", kCameraType, 0, ros_.camera(4, 2, {4, 4, 1.5, 0.5}));
  for (const std::int64_t ms : {1000, 1033, 1066, 500, 533}) {
    const std::int64_t time = ms * 1'000'000;
    bag.add("/d/image", kImageType, 1, ros_.image(time, "d", "16UC1", 4, 2, counted_depth(1000, 8)));
    bag.add("/c/image", kImageType, 1, ros_.image(time, "d", "rgb8", 1, 1, Bytes(3, static_cast<std::byte>(ms % 251))));
  }
  const Played p = played(bag, still());
  ASSERT_EQ(p.frames.size(), 5u);
  EXPECT_EQ(p.frames[4].timestamp_ns, 1'132'000'000);
  for (std::size_t i = 0; i < 5; ++i) {
    constexpr std::array<int, 5> kTimes = {1000, 1033, 1066, 500, 533};
    ASSERT_TRUE(p.frames[i].colour) << i;
    EXPECT_EQ(p.frames[i].colour->image.at(0, 0).r, kTimes[i] % 251);
  }
  EXPECT_TRUE(contains(described(bag).warnings.at(0), "step back or stand still 1 times"));
}

// What Foxglove's own libraries write from a folder equals the folder, to the last bit of depth and colour.
class Ros2OfFoxglove : public ::testing::TestWithParam<const char*> {};

TEST_P(Ros2OfFoxglove, EqualsTheFolderItWasWrittenFrom) {
  const TemporaryFolder folder;
  const fs::path input = folder / "in";
  write_text(input / "camera_intrinsic.json",
             R"({"width": 8, "height": 6, "intrinsic_matrix": [100, 0, 0, 0, 110, 0, 3.5, 2.5, 1]})");
  std::string log;
  for (int i = 0; i < 12; ++i) {
    const std::string name = std::string(i < 10 ? "0" : "") + std::to_string(i);
    write_depth(input / ("depth/" + name + ".png"), static_cast<std::uint16_t>(1000 + i));
    write_colour(input / ("color/" + name + (i % 2 == 0 ? ".png" : ".jpg")), {static_cast<std::uint8_t>(9 * i), 5, 6});
    const double c = std::cos(0.3 * i), s = std::sin(0.3 * i);
    std::ostringstream pose;
    pose << std::setprecision(17) << "0 0 0\n"
         << c << " " << -s << " 0 " << 0.1 * i << "\n"
         << s << " " << c << " 0 2\n0 0 1 3\n0 0 0 1\n";
    log += pose.str();
  }
  write_text(input / "trajectory.log", log);
  const std::string command = "node '" + kSourceDir + "/tests/acquire/write_ros2_bag.mjs' '" + kNpmDir + "' '" +
                              input.string() + "' '" + (folder / "bag.mcap").string() + "' " + GetParam();
  const int status = std::system(command.c_str());  // NOLINT(concurrency-mt-unsafe): one thread
  constexpr int kSkipped = 77, kNoSuchCommand = 127;
  if (WEXITSTATUS(status) == kSkipped || WEXITSTATUS(status) == kNoSuchCommand) {
    GTEST_SKIP() << "SKIPPED: node or @mcap/core is not installed (npm ci in " << kNpmDir << ")";
  }
  ASSERT_EQ(status, 0) << command;
  const Played before = play(input), after = play(folder / "bag.mcap");
  ASSERT_EQ(after.frames.size(), 12u);
  for (std::size_t i = 0; i < after.frames.size(); ++i) {
    const Frame &a = before.frames.at(i), &b = after.frames[i];
    EXPECT_EQ(b.depth_m, a.depth_m);
    EXPECT_EQ(b.intrinsics, a.intrinsics);
    ASSERT_TRUE(b.colour);
    EXPECT_EQ(*b.colour->encoded, *a.colour->encoded);
    EXPECT_EQ(b.colour->intrinsics, a.colour->intrinsics);
    constexpr double kRounding = 1e-14;  // a quaternion in between
    EXPECT_TRUE(b.T_world_camera->isApprox(*a.T_world_camera, kRounding));
  }
}

INSTANTIATE_TEST_SUITE_P(BothLayouts, Ros2OfFoxglove, ::testing::Values("chunks", "no_chunks"),
                         [](const auto& layout) { return std::string(layout.param); });

TEST(Ros2Messages, CutAtAnyByteAreRefused) {
  for (const bool is_little : {true, false}) {
    const Ros2Writer ros{is_little};
    const auto expect_refused = [](const Bytes& whole, std::size_t needed, auto parse) {
      EXPECT_TRUE(parse(whole));
      for (std::size_t size = 0; size < needed; ++size) {
        EXPECT_FALSE(parse(std::span(whole).first(size))) << size << " of " << whole.size();
      }
    };
    const auto expect_all_needed = [&](const Bytes& whole, auto parse) { expect_refused(whole, whole.size(), parse); };
    const std::vector<double> pose = {1, 2, 3, 0, 0, 0, 1};
    expect_all_needed(ros.image(1, "d", "rgb8", 1, 1, Bytes(3)), parse_image);
    expect_all_needed(ros.compressed(1, "d", "png", Bytes(3)), parse_compressed_image);
    expect_all_needed(ros.transform(1, "a", "b", pose), parse_transforms);
    expect_all_needed(ros.pose(1, "a", pose), parse_pose_stamped);
    const Bytes odometry = ros.odometry(1, "a", "b", pose);
    expect_refused(odometry, odometry.size() - (36 + 6 + 36) * sizeof(double), parse_odometry);
    const Bytes camera = ros.camera(4, 2, {4, 4, 1.5, 0.5});
    expect_refused(camera, camera.size() - 9, parse_camera_info);  // the size of the region, and a flag
  }
}

TEST(Ros2Messages, PromiseNoMoreThanTheyHold) {
  Bytes message = CdrWriter(true).number(std::uint32_t{0xFFFF'FFFF}).bytes();
  EXPECT_FALSE(parse_transforms(message));
  message = CdrWriter(true)
                .header(1, "d")
                .number(2u)
                .number(2u)
                .text("rgb8")
                .number(std::uint8_t{0})
                .number(6u)
                .number(0xFFFF'FFFFu)
                .bytes();
  EXPECT_FALSE(parse_image(message));
  message[1] = std::byte{2};
  EXPECT_FALSE(parse_image(message)) << "a parameter list, which no such message is";
}

TEST(Ros2Messages, RefusePosesThatAreNone) {
  const Ros2Writer ros;
  EXPECT_FALSE(parse_pose_stamped(ros.pose(1, "a", {0, 0, 0, 0, 0, 0, 0}))->T_parent_child);
  EXPECT_FALSE(parse_pose_stamped(ros.pose(1, "a", {std::nan(""), 0, 0, 0, 0, 0, 1}))->T_parent_child);
  EXPECT_FALSE(parse_pose_stamped(ros.pose(1, "a", {0, 0, 0, std::nan(""), 0, 0, 1}))->T_parent_child);
}

}  // namespace
}  // namespace scanknit::test
