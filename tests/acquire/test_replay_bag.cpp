// RealSense Viewer's bags: the container by bytes that tests write, the topics by a real recording.
#include <gtest/gtest.h>

#include <array>
#include <map>

#include "acquire/bag/ros_bag.h"
#include "acquire/mcap/byte_appender.h"
#include "ros1_bag.h"
#include "test_replay_support.h"
#include "tests/support/text.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t kMagicBytes = 13;

// Of two messages each.
std::vector<Bytes> three_chunks() {
  std::vector<Bytes> chunks(3);
  for (std::uint32_t i = 0; i < 3; ++i) {
    append_connection(chunks[i], 7, "/a", "std_msgs/String");
    append_message(chunks[i], 7, 10 + i, bytes_of_text("first " + std::to_string(i)));
    append_message(chunks[i], 7, 10.5 + i, bytes_of_text("second " + std::to_string(i)));
  }
  return chunks;
}

Bytes small_bag(const std::string& compression) {
  return bag_of(three_chunks(), compression);
}

Result<RosBag> open(const Bytes& bag, const Limits& limits = {}) {
  return RosBag::open(std::make_unique<MemoryAccess>(bag), limits);
}

class Bag : public ::testing::TestWithParam<std::string> {};

TEST_P(Bag, GivesBackEveryMessage) {
  const Bytes bytes = small_bag(GetParam());
  auto bag = open(bytes);
  ASSERT_TRUE(bag) << bag.error().text();
  EXPECT_FALSE(bag->fault());
  ASSERT_EQ(bag->connections().size(), 1u);
  EXPECT_EQ(bag->connections()[0].topic, "/a");
  EXPECT_EQ(bag->connections()[0].type, "std_msgs/String");
  ASSERT_EQ(bag->messages().size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) {
    const auto data = bag->read(bag->messages()[i]);
    ASSERT_TRUE(data);
    const std::string expected = (i % 2 == 0 ? "first " : "second ") + std::to_string(i / 2);
    EXPECT_EQ(Bytes(data->begin(), data->end()), bytes_of_text(expected));
    EXPECT_EQ(bag->messages()[i].time_ns, 10'000'000'000 + static_cast<std::int64_t>(i) * 500'000'000);
  }
}

TEST_P(Bag, CutAtAnyByteKeepsEveryWholeChunk) {
  const Bytes whole = small_bag(GetParam());
  std::size_t before = 0;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    auto bag = open(cut);
    EXPECT_EQ(static_cast<bool>(bag), size >= kMagicBytes);
    const std::size_t messages = bag ? bag->messages().size() : 0;
    EXPECT_GE(messages, before);
    EXPECT_EQ(messages % 2, 0u);
    before = messages;
    if (!bag) continue;
    const std::string fault = bag->fault().value_or("none");
    EXPECT_EQ(fault.find("it is cut off at byte " + std::to_string(size) + ","), 0u) << fault;
  }
  EXPECT_EQ(before, 6u) << "the index is cut last";
}

TEST_P(Bag, ThatWasNeverFinishedSaysSo) {
  const Bytes bytes = unfinished_bag(three_chunks(), GetParam());
  for (const std::size_t less : {0u, 1u, 10u}) {
    const Bytes cut(bytes.begin(), bytes.end() - static_cast<std::ptrdiff_t>(less));
    auto bag = open(cut);
    ASSERT_TRUE(bag);
    EXPECT_EQ(bag->messages().size(), less == 0 ? 6u : 4u);
    const std::string fault = bag->fault().value_or("none");
    EXPECT_NE(fault.find("has not finished it"), std::string::npos) << fault;
  }
}

TEST_P(Bag, DamagedIsNotCalledCut) {
  Bytes bytes = small_bag(GetParam());
  bytes[kMagicBytes + 3] = std::byte{0x7F};  // the length of the first record's header
  auto bag = open(bytes);
  ASSERT_TRUE(bag);
  const std::string fault = bag->fault().value_or("none");
  EXPECT_EQ(fault, "it is damaged at byte 13 of " + std::to_string(bytes.size()));
}

TEST_P(Bag, SurvivesAnyWrongByte) {
  const Bytes whole = small_bag(GetParam());
  for (std::size_t i = 0; i < whole.size(); ++i) {
    Bytes damaged = whole;
    damaged[i] ^= std::byte{0xFF};
    auto bag = open(damaged);
    if (!bag) continue;
    for (const BagMessage& message : bag->messages()) {
      const auto data = bag->read(message);
      EXPECT_TRUE(!data || data->size() == message.length);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(AllCompressions, Bag, ::testing::Values("none", "lz4", "bz2"),
                         [](const auto& compression) { return compression.param; });

TEST(BagLimits, HoldBeforeMemoryIsAskedFor) {
  Limits limits;
  limits.max_image_bytes = 20;
  const Bytes bytes = small_bag("lz4");
  const auto bag = open(bytes, limits);
  ASSERT_TRUE(bag);
  EXPECT_TRUE(bag->messages().empty());
  EXPECT_TRUE(bag->fault());
  limits = {};
  limits.max_frames = 5;
  EXPECT_FALSE(open(bytes, limits));
}

TEST(BagLimits, AnotherKindOfBagIsRefusedWithWords) {
  const TemporaryFolder folder;
  write_bytes(folder / "a.bag", small_bag("none"));
  const std::string error = open_error(folder / "a.bag");
  EXPECT_NE(error.find("a bag without depth pictures"), std::string::npos) << error;
  EXPECT_NE(error.find("its topics: /a (std_msgs/String)"), std::string::npos) << error;
}

Bytes image_message(const std::string& encoding, std::uint32_t width, std::uint32_t height, std::uint32_t step,
                    const Bytes& data) {
  Bytes bytes;
  ByteAppender writer(bytes);
  writer.little_endian(std::uint32_t{5});
  writer.little_endian(std::uint64_t{99});
  writer.text("0");
  writer.little_endian(height);
  writer.little_endian(width);
  writer.text(encoding);
  writer.little_endian(std::uint8_t{0});
  writer.little_endian(step);
  writer.little_endian(static_cast<std::uint32_t>(data.size()));
  writer.append(data);
  return bytes;
}

Bytes camera_message(std::uint32_t width, std::uint32_t height, const std::string& lens, double k1) {
  Bytes bytes;
  ByteAppender writer(bytes);
  writer.append(Bytes(12));
  writer.text("0");
  writer.little_endian(height);
  writer.little_endian(width);
  writer.text(lens);
  writer.little_endian(std::uint32_t{5});
  for (const double value : {k1, 0.0, 0.0, 0.0, 0.0}) writer.little_endian(value);
  for (const double value : {4.0, 0.0, 1.5, 0.0, 4.5, 0.5, 0.0, 0.0, 1.0}) writer.little_endian(value);
  return bytes;
}

Bytes transform_message(double x, double w) {
  Bytes bytes;
  ByteAppender writer(bytes);
  for (const double value : {x, 0.0, 0.0, 0.0, 0.0, 0.0, w}) writer.little_endian(value);
  return bytes;
}

Bytes float_message(float value) {
  Bytes bytes;
  ByteAppender(bytes).little_endian(value);
  return bytes;
}

// A picture of 4 x 2 pixels whose rows are padded to 12 bytes.
Bytes depth_message() {
  Bytes depth;
  ByteAppender writer(depth);
  for (const unsigned row : {100u, 200u}) {
    for (unsigned x = 0; x < 4; ++x) writer.little_endian(static_cast<std::uint16_t>(row + x));
    writer.little_endian(std::uint32_t{0xFFFF'FFFF});
  }
  return image_message("mono16", 4, 2, 12, depth);
}

// What a camera of such pictures says of itself, and a picture of depth and of colour.
Bytes camera_chunk(const std::string& lens = "Brown Conrady", double k1 = 0) {
  const std::map<std::uint32_t, std::string> topics = {{1, "/device_0/sensor_0/Depth_0/image/data"},
                                                       {2, "/device_0/sensor_0/Depth_0/info/camera_info"},
                                                       {3, "/device_0/sensor_0/Depth_0/tf/0"},
                                                       {4, "/device_0/sensor_1/Color_0/image/data"},
                                                       {5, "/device_0/sensor_1/Color_0/info/camera_info"},
                                                       {6, "/device_0/sensor_1/Color_0/tf/0"},
                                                       {7, "/device_0/sensor_0/option/Depth Units/value"}};
  Bytes chunk;
  for (const auto& [id, topic] : topics) append_connection(chunk, id, topic, "any");
  append_message(chunk, 2, 0, camera_message(4, 2, lens, k1));
  append_message(chunk, 5, 0, camera_message(4, 2, lens, 0));
  append_message(chunk, 3, 0, transform_message(0, 1));
  append_message(chunk, 7, 0, float_message(0.01F));
  append_message(chunk, 1, 1.0, depth_message());
  append_message(chunk, 4, 1.01, image_message("rgb8", 4, 2, 12, Bytes(24, std::byte{77})));
  return chunk;
}

// Where the colour camera is, which real bags say last, and another picture of depth.
Bytes later_chunk() {
  Bytes chunk;
  append_message(chunk, 6, 0, transform_message(0.015, 1));
  append_message(chunk, 1, 2.0, depth_message());
  return chunk;
}

Bytes camera_bag(const std::string& lens = "Brown Conrady", double k1 = 0) {
  return bag_of({camera_chunk(lens, k1), later_chunk()}, "lz4");
}

TEST(RealsenseBag, HasCamerasUnitAndTheWayBetweenThem) {
  const TemporaryFolder folder;
  write_bytes(folder / "a.bag", camera_bag());
  AcquireConfig config;
  config.poses = PoseMode::kStill;
  const Played played = play(folder / "a.bag", config);
  ASSERT_EQ(played.frames.size(), 2u);
  const Frame& frame = played.frames[0];
  EXPECT_EQ(frame.intrinsics, (CameraIntrinsics{4, 2, 4, 4.5, 1.5, 0.5}));
  EXPECT_EQ(frame.depth_m.at(0, 0), 1.0F) << "hundredths of a metre";
  EXPECT_EQ(frame.depth_m.at(3, 1), 2.03F) << "rows are padded";
  ASSERT_TRUE(frame.colour);
  EXPECT_EQ(frame.colour->image.at(3, 1), (Rgb8{77, 77, 77}));
  EXPECT_EQ(frame.colour->T_colour_depth.translation(), Eigen::Vector3d(0.015, 0, 0));
  EXPECT_EQ(frame.timestamp_ns, 1'000'000'000);
}

TEST(RealsenseBag, SaysWhenItCannotStraightenALens) {
  const TemporaryFolder folder;
  write_bytes(folder / "a.bag", camera_bag("Inverse Brown Conrady", 0.1));
  const auto source = open_recording(folder / "a.bag", {});
  ASSERT_TRUE(source);
  EXPECT_EQ((*source)->info().warnings.size(), 1u);
}

/// What a bag of which only the first `size` bytes are left must say and give. How many frames it gives.
std::size_t frames_of_cut(const fs::path& file, const Bytes& whole, std::size_t size) {
  write_bytes(file, Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)));
  AcquireConfig config;
  config.poses = PoseMode::kStill;
  const std::string expected = "the bag is torn";
  const auto source = open_recording(file, config);
  if (!source) {
    const std::string error = source.error().text();
    EXPECT_TRUE(contains(error, size < kMagicBytes ? "no recording of a known layout" : expected)) << error;
    EXPECT_FALSE(contains(error, "other bags")) << error;
    return 0;
  }
  const std::vector<std::string> warnings = (*source)->info().warnings;
  const Played played = play(**source);
  EXPECT_TRUE(played.dropped.empty() && played.errors.empty());
  const std::size_t expected_warnings =
      played.frames.size() < 2 ? 2 : 1;  // where colour is comes with the second frame
  EXPECT_EQ(warnings.size(), expected_warnings);
  if (warnings.size() != expected_warnings) return played.frames.size();
  EXPECT_TRUE(contains(warnings[0], expected + ": it is cut off at byte " + std::to_string(size))) << warnings[0];
  EXPECT_EQ(contains(warnings.back(), "does not say where its colour camera is"), expected_warnings == 2);
  return played.frames.size();
}

TEST(RealsenseBag, CutAtAnyByteSaysSoAndGivesTheFramesBefore) {
  const TemporaryFolder folder;
  const Bytes whole = camera_bag();
  std::size_t before = 0;
  std::array<std::size_t, 3> cuts_that_give{};
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const std::size_t frames = frames_of_cut(folder / "a.bag", whole, size);
    ASSERT_TRUE(frames >= before && frames <= 2) << size;
    before = frames;
    ++cuts_that_give[frames];
  }
  for (const std::size_t cuts : cuts_that_give) EXPECT_GT(cuts, 10u);
}

TEST(RealsenseBag, OfARealCameraCutAnywhereSaysSoAndGivesTheFramesBefore) {
  const fs::path file = data_folder() / "realsense_bag" / "single_depth_color_640x480.bag";
  if (!fs::exists(file)) GTEST_SKIP() << "SKIPPED: no realsense_bag to read";
  const TemporaryFolder folder;
  const Bytes whole = bytes_of(file);
  constexpr std::size_t kCuts = 40;
  std::size_t before = 0;
  for (std::size_t i = 0; i < kCuts; ++i) {
    const std::size_t frames = frames_of_cut(folder / "a.bag", whole, whole.size() * i / kCuts);
    ASSERT_GE(frames, before);
    before = frames;
  }
  EXPECT_EQ(before, 2u);
}

TEST(RealsenseBag, OfARealCameraIsReadWhole) {
  const fs::path file = data_folder() / "realsense_bag" / "single_depth_color_640x480.bag";
  if (!fs::exists(file)) GTEST_SKIP() << "SKIPPED: no realsense_bag to read";
  AcquireConfig config;
  config.poses = PoseMode::kStill;
  auto source = open_recording(file, config);
  ASSERT_TRUE(source) << source.error().text();
  EXPECT_EQ((*source)->info().format, "realsense-bag");
  EXPECT_EQ((*source)->info().frames, 2u);
  EXPECT_TRUE((*source)->info().warnings.empty());
  const Played played = play(**source);
  ASSERT_EQ(played.frames.size(), 2u);
  const Frame& frame = played.frames[0];
  EXPECT_NEAR(frame.intrinsics.fx, 390.45, 0.1);
  EXPECT_EQ(frame.depth_m.width(), 640);
  ASSERT_TRUE(frame.colour) << "taken 54 ms after the first depth picture";
  EXPECT_NEAR(frame.colour->intrinsics.fx, 613.2, 0.1);
  // A D435's colour camera sits a centimetre and a half beside the left one.
  EXPECT_NEAR(frame.colour->T_colour_depth.translation().x(), 0.0143, 0.0001);
  EXPECT_TRUE(is_rigid(frame.colour->T_colour_depth));
  EXPECT_FALSE(played.frames[1].colour) << "farther than half a period of six frames a second";
  std::size_t seen = 0;
  for (const float z : frame.depth_m.pixels()) seen += z > 0.1F && z < 10 ? 1u : 0u;
  EXPECT_GT(seen, frame.depth_m.size() / 2);
}

}  // namespace
}  // namespace scanknit::test
