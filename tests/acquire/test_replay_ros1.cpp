// Bags of ROS 1 that are not RealSense Viewer's.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "acquire/raw/raw_recording.h"
#include "acquire/ros2/ros2_messages.h"
#include "core/picture/png_codec.h"
#include "robot_frames.h"
#include "ros1_bag.h"
#include "ros2_bag.h"
#include "test_replay_support.h"
#include "tests/support/text.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;

/// `log` in one chunk; types are written as ROS 1 does.
Bytes ros1_file(const std::vector<Ros2Bag::Logged>& log, const std::string& compression = "none") {
  Bytes chunk;
  std::map<std::string, std::uint32_t> connections;
  for (const Ros2Bag::Logged& message : log) {
    const auto [id, is_new] = connections.try_emplace(message.topic, static_cast<std::uint32_t>(connections.size()));
    std::string type = message.type;
    if (const auto middle = type.find("/msg/"); middle != std::string::npos) type.erase(middle, 4);
    if (is_new) append_connection(chunk, id->second, message.topic, type);
    append_message(chunk, id->second, static_cast<double>(message.log_ns) * 1e-9, message.data);
  }
  return bag_of({chunk}, compression);
}

std::vector<Ros2Bag::Logged> robot_log() {
  return Robot{{true, true}}.bag().log();
}

class Ros1File : public ::testing::TestWithParam<const char*> {};

TEST_P(Ros1File, GivesFramesWithCamerasAndPoses) {
  const TemporaryFolder folder;
  write_bytes(folder / "robot.bag", ros1_file(robot_log(), GetParam()));
  expect_robot(play(folder / "robot.bag"));
  const auto source = open_recording(folder.path(), {});
  ASSERT_TRUE(source);
  EXPECT_EQ((*source)->info().format, "ros1");
  EXPECT_TRUE((*source)->info().warnings.empty()) << (*source)->info().warnings.front();
  EXPECT_EQ((*source)->info().topics.at("poses"), "tf: map from depth_link");
}

std::size_t frames_in_ros1(const Bytes& file) {
  const auto recording = index_ros1(std::make_unique<MemoryAccess>(file), "a.bag", {});
  if (!recording) return 0;
  const auto& entries = recording->entries;
  return static_cast<std::size_t>(std::count_if(entries.begin(), entries.end(), [&](const FrameEntry& entry) {
    return std::holds_alternative<DecodedFrame>(recording->decode(entry, {}));
  }));
}

TEST_P(Ros1File, SurvivesAnyWrongByteAndAnyCut) {
  const Bytes whole = ros1_file(robot_log(), GetParam());
  EXPECT_EQ(frames_in_ros1(whole), 2u);
  for (std::size_t i = 0; i < whole.size(); ++i) {
    Bytes damaged = whole;
    damaged[i] ^= std::byte{0xFF};
    EXPECT_LE(frames_in_ros1(damaged), 2u);
    EXPECT_LE(frames_in_ros1(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(i))), 2u);
  }
}

INSTANTIATE_TEST_SUITE_P(AllCompressions, Ros1File, ::testing::Values("none", "lz4", "bz2"),
                         [](const auto& compression) { return std::string(compression.param); });

TEST(Ros1, KnowsTheOldNameOfTf) {
  const TemporaryFolder folder;
  auto log = robot_log();
  for (Ros2Bag::Logged& message : log) {
    if (message.type == kTransformType) message.type = "tf/tfMessage";
  }
  write_bytes(folder / "robot.bag", ros1_file(log));
  expect_robot(play(folder / "robot.bag"));
}

TEST(Ros1Messages, CutAtAnyByteAreRefused) {
  const Ros2Writer ros{true, true};
  const auto expect_needed = [](const Bytes& whole, std::size_t unneeded, auto parse) {
    const auto as_ros1 = [](std::span<const std::byte> bytes) { return RosMessage(bytes, RosEncoding::kRos1); };
    EXPECT_TRUE(parse(as_ros1(whole)));
    for (std::size_t size = 0; size + unneeded < whole.size(); ++size) {
      EXPECT_FALSE(parse(as_ros1(std::span(whole).first(size)))) << size << " of " << whole.size();
    }
  };
  const std::vector<double> pose = {1, 2, 3, 0, 0, 0, 1};
  expect_needed(ros.image(1, "d", "rgb8", 1, 1, Bytes(3)), 0, parse_image);
  expect_needed(ros.compressed(1, "d", "png", Bytes(3)), 0, parse_compressed_image);
  expect_needed(ros.transform(1, "a", "b", pose), 0, parse_transforms);
  expect_needed(ros.pose(1, "a", pose), 0, parse_pose_stamped);
  expect_needed(ros.camera(4, 2, {4, 4, 1.5, 0.5}), 9, parse_camera_info);  // the size of the region, and a flag
}

// What ROS 1's own library writes.
TEST(Ros1, IsReadAsRosbagWritesIt) {
  const TemporaryFolder folder;
  for (const char* compression : {"none", "bz2", "lz4"}) {
    const std::string file = (folder / (std::string(compression) + ".bag")).string();
    const std::string command =
        "/usr/bin/python3 '" + kSourceDir + "/tests/acquire/write_ros1_bag.py' '" + file + "' " + compression;
    const int status = std::system(command.c_str());  // NOLINT(concurrency-mt-unsafe): one thread
    constexpr int kSkipped = 77, kNoSuchCommand = 127;
    if (WEXITSTATUS(status) == kSkipped || WEXITSTATUS(status) == kNoSuchCommand) {
      GTEST_SKIP() << "SKIPPED: python3-rosbag, python3-sensor-msgs or python3-tf2-msgs is not installed";
    }
    ASSERT_EQ(status, 0) << command;
    expect_robot(play(file));
  }
}

}  // namespace
}  // namespace scanknit::test
