// Bags of ROS whose clouds are the sweeps of a LiDAR.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <random>
#include <variant>

#include "acquire/frame_source.h"
#include "acquire/lidar/bag_sweeps.h"
#include "acquire/lidar/cloud_sweep.h"
#include "acquire/lidar/sweep_grid.h"
#include "acquire/recording_format.h"
#include "lidar_bag.h"
#include "robot_frames.h"
#include "ros1_bag.h"
#include "test_replay_support.h"
#include "tests/support/text.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;

constexpr double kExact_m = 0.001;

std::unique_ptr<SweepSource> opened(const fs::path& path, const AcquireConfig& config = {}) {
  EXPECT_TRUE(is_sweep_recording(path, config));
  auto source = open_sweeps(path, config);
  EXPECT_TRUE(source) << (source ? "" : source.error().text());
  return source ? *std::move(source) : nullptr;
}

/// Of all points of all sweeps the farthest from the room's walls; without them, infinity.
double farthest_off_walls_m(SweepSource& source) {
  double farthest = -1;
  for (std::size_t i = 0; i < source.info().sweeps; ++i) {
    const auto event = source.read(i);
    const auto* sweep = std::get_if<Sweep>(&event);
    if (sweep == nullptr) continue;
    for (const Eigen::Vector3f& p : sweep->points_m) {
      farthest = std::max(farthest, off_walls_m(sweep->T_world_sensor * p.cast<double>()));
    }
  }
  return farthest >= 0 ? farthest : std::numeric_limits<double>::infinity();
}

bool warns(const SweepSource& source, const std::string& of) {
  const auto& warnings = source.info().warnings;
  return std::any_of(warnings.begin(), warnings.end(), [&](const std::string& text) { return contains(text, of); });
}

/// As rosbag writes it: `log` in one chunk, and the connections again in the index. Types are written as in ROS 1.
Bytes ros1_file(const std::vector<Ros2Bag::Logged>& log) {
  Bytes chunk, index;
  std::map<std::string, std::uint32_t> connections;
  for (const Ros2Bag::Logged& message : log) {
    const auto [id, is_new] = connections.try_emplace(message.topic, static_cast<std::uint32_t>(connections.size()));
    const std::string type = without_msg(message.type);
    if (is_new) append_connection(chunk, id->second, message.topic, type);
    if (is_new) append_connection(index, id->second, message.topic, type);
    append_message(chunk, id->second, static_cast<double>(message.log_ns) * 1e-9, message.data);
  }
  Bytes bag = unfinished_bag({chunk}, "none", unfinished_bag({chunk}, "none").size());
  append_record(index, {number_field<std::uint8_t>("op", 6), number_field("count", 1u)}, Bytes(8));
  bag.insert(bag.end(), index.begin(), index.end());
  return bag;
}

class LidarBag : public ::testing::Test {
 protected:
  fs::path write(const Ros2Bag& bag, const std::string& name = "walk.mcap") const {
    write_bytes(folder_ / name, bag.file());
    return folder_ / name;
  }
  TemporaryFolder folder_;
};

struct Driver {
  const char* name;
  CloudFormat format;
};

class LidarDriver : public LidarBag, public ::testing::WithParamInterface<Driver> {};

TEST_P(LidarDriver, GivesPointsOnTheWallsThoughTheScannerMoves) {
  LidarWalk walk;
  walk.format = GetParam().format;
  const auto source = opened(write(walk.bag()));
  ASSERT_NE(source, nullptr);
  EXPECT_LT(farthest_off_walls_m(*source), kExact_m);
  EXPECT_TRUE(source->info().warnings.empty()) << source->info().warnings.front();
  const auto event = source->read(1);
  const auto* sweep = std::get_if<Sweep>(&event);
  ASSERT_NE(sweep, nullptr);
  EXPECT_EQ(sweep->points_m.size(), walk.points_of(1).size() - 1) << "all but the one without return";
  EXPECT_EQ(sweep->timestamp_ns, walk.stamp_ns(1));
  EXPECT_TRUE(sweep->T_world_sensor.isApprox(LidarWalk::lidar_at(walk.stamp_ns(1)), 1e-4));
  EXPECT_EQ(find_rows(*sweep).rows, walk.model.rings);
  if (!walk.format.ring_name.empty()) {
    EXPECT_EQ(find_rows(*sweep).kind, SweepRows::Kind::kRings);
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, LidarDriver,
    ::testing::Values(
        Driver{"Velodyne", {.is_stamp_at_end = true}},
        Driver{"VelodyneInRows", {.is_stamp_at_end = true, .has_rows = true}},
        Driver{"Ouster",
               {.time_name = "t",
                .time_type = kUint32Field,
                .time_units_per_s = 1e9,
                .ring_type = kUint8Field,
                .has_rows = true}},
        Driver{"Hesai", {.time_name = "timestamp", .time_type = kFloat64Field, .is_time_absolute = true}},
        Driver{"Robosense",
               {.time_name = "timestamp",
                .time_type = kFloat64Field,
                .is_time_absolute = true,
                .is_stamp_at_end = true,
                .has_rows = true}},
        Driver{"Livox",
               {.time_name = "timestamp",
                .time_type = kFloat64Field,
                .time_units_per_s = 1e9,
                .is_time_absolute = true,
                .ring_name = ""}},
        Driver{"OffsetTime", {.time_name = "offset_time", .time_type = kUint32Field, .time_units_per_s = 1e9}},
        Driver{"RelativeDouble", {.time_name = "time_stamp", .time_type = kFloat64Field, .ring_name = "channel"}},
        Driver{"BigEndianDouble", {.ring_type = kUint32Field, .place_type = kFloat64Field, .is_big_endian = true}}),
    [](const auto& driver) { return std::string(driver.param.name); });

TEST_F(LidarBag, WithoutTimesIsAsTheScannerSawItAndSaysSo) {
  LidarWalk walk;
  for (const char* name : {"", "time"}) {
    walk.format.time_name = name;
    walk.format.time_units_per_s = 0;  // a field that is there, and says nothing
    const auto source = opened(write(walk.bag()));
    ASSERT_NE(source, nullptr);
    EXPECT_GT(farthest_off_walls_m(*source), 20 * kExact_m);
    EXPECT_LT(farthest_off_walls_m(*source), 0.5);
    EXPECT_TRUE(warns(*source, "have no times")) << name;
  }
}

TEST_F(LidarBag, WhosePathEndsWithinTheLastSweepSaysSo) {
  LidarWalk walk;
  walk.tf_beyond_ns = -LidarWalk::kTurn_ns / 2;
  walk.sweeps = 5;
  const auto source = opened(write(walk.bag()));
  ASSERT_NE(source, nullptr);
  EXPECT_EQ(source->info().sweeps_with_pose, 4u) << "the first one is before the path";
  EXPECT_TRUE(warns(*source, "do not reach over the whole of 1 of 4 sweeps"));
  ASSERT_TRUE(std::holds_alternative<FrameDropped>(source->read(0)));
  EXPECT_EQ(std::get<FrameDropped>(source->read(0)).reason, DropReason::kNoPose);
  EXPECT_TRUE(std::holds_alternative<Sweep>(source->read(4)));
}

TEST_F(LidarBag, OfRos1IsReadAlike) {
  LidarWalk walk;
  walk.ros = {true, true};
  write_bytes(folder_ / "walk.bag", ros1_file(walk.bag().log()));
  for (const fs::path& path : {folder_ / "walk.bag", folder_.path()}) {
    const auto source = opened(path);
    ASSERT_NE(source, nullptr);
    EXPECT_EQ(source->info().format, "ros1");
    EXPECT_EQ(source->info().sweeps, 4u);
    EXPECT_EQ(source->info().sweeps_with_pose, 4u);
    EXPECT_NEAR(*source->info().duration_s, 0.3, 1e-6);
    EXPECT_EQ(source->info().world_up, UpAxis::kZ);
    EXPECT_LT(farthest_off_walls_m(*source), kExact_m);
  }
}

TEST_F(LidarBag, IsFoundByTheFolderOfItsParts) {
  LidarWalk walk;
  Ros2Bag tf, clouds;
  walk.add_tf(tf);
  walk.add_clouds(clouds);
  write(tf, "walk_0.mcap");
  write(clouds, "walk_1.mcap");
  const auto source = opened(folder_.path());
  ASSERT_NE(source, nullptr);
  EXPECT_LT(farthest_off_walls_m(*source), kExact_m);
}

TEST_F(LidarBag, WithoutTfHasNoPoses) {
  LidarWalk walk;
  Ros2Bag bag;
  walk.add_clouds(bag);
  const auto source = opened(write(bag));
  ASSERT_NE(source, nullptr);
  EXPECT_EQ(source->info().sweeps, 4u);
  EXPECT_EQ(source->info().sweeps_with_pose, 0u);
  EXPECT_TRUE(contains(source->info().expected_poses, "'lidar' of /points"));
  const auto event = source->read(2);
  ASSERT_TRUE(std::holds_alternative<FrameDropped>(event));
  EXPECT_EQ(std::get<FrameDropped>(event).reason, DropReason::kNoPose);
}

TEST_F(LidarBag, TakesPosesOfATopic) {
  LidarWalk walk;
  Ros2Bag bag;
  walk.add_clouds(bag);
  for (std::int64_t time = LidarWalk::kBegin_ns; time <= walk.end_ns(); time += 10'000'000) {
    bag.add("/slam", "geometry_msgs/msg/PoseStamped", time,
            walk.ros.pose(time, "map", LidarWalk::numbers_of(LidarWalk::lidar_at(time))));
  }
  const fs::path path = write(bag);
  const auto guessed = opened(path);
  ASSERT_NE(guessed, nullptr);
  EXPECT_TRUE(warns(*guessed, "the poses of /slam are taken for the scanner's"));
  AcquireConfig config;
  config.topics.poses = "/slam";
  const auto source = opened(path, config);
  ASSERT_NE(source, nullptr);
  EXPECT_TRUE(source->info().warnings.empty());
  EXPECT_LT(farthest_off_walls_m(*source), kExact_m);
  config.topics.poses = "/other";
  const auto refused = open_sweeps(path, config);
  ASSERT_FALSE(refused);
  EXPECT_TRUE(contains(refused.error().message, "acquire.topics.poses"));
}

TEST_F(LidarBag, WithDepthPicturesIsADepthRecordingUnlessItsCloudsAreNamed) {
  LidarWalk walk;
  Ros2Bag bag = robot_bag();
  walk.add_tf(bag);
  walk.add_clouds(bag);
  const fs::path path = write(bag);
  EXPECT_FALSE(is_sweep_recording(path, {}));
  expect_robot(play(path));
  AcquireConfig config;
  config.topics.depth = "/points";
  const auto source = opened(path, config);
  ASSERT_NE(source, nullptr);
  EXPECT_LT(farthest_off_walls_m(*source), kExact_m);
  config.topics.depth = "/cam/depth/image_raw";
  EXPECT_FALSE(is_sweep_recording(path, config));
}

TEST_F(LidarBag, OfAnotherFormatIsNoSweepRecording) {
  const fs::path path = write(LidarWalk{}.bag());
  AcquireConfig config;
  config.format = RecordingFormat::kOni;
  EXPECT_FALSE(is_sweep_recording(path, config));
  config.format = RecordingFormat::kRos2;
  EXPECT_TRUE(is_sweep_recording(path, config));
  EXPECT_TRUE(contains(open_error(path), "the clouds of /points are LiDAR sweeps"));
}

TEST_F(LidarBag, ReadsTheTopicThatMoves) {
  LidarWalk walk;
  Ros2Bag bag = walk.bag();
  CloudFormat map_format;
  for (int i = 0; i < 9; ++i) {
    bag.add("/a_map", kCloudType, 1,
            cloud_of_points(walk.ros, map_format, walk.stamp_ns(i), "map", walk.points_of(0), 1));
  }
  const auto source = opened(write(bag));
  ASSERT_NE(source, nullptr);
  EXPECT_EQ(source->info().sweeps, 4u);
  EXPECT_TRUE(warns(*source, "the sweeps of /points are read, not those of /a_map"));
  const std::map<std::string, std::string> topics = {
      {"depth", "/points"}, {"not_read", "/a_map"}, {"poses", "tf: map from lidar"}};
  EXPECT_EQ(source->info().topics, topics);
}

TEST_F(LidarBag, ListsOfADepthCamerasPointsAreNoSweeps) {
  LidarWalk walk;
  Ros2Bag bag;
  bag.add("/points", kCloudType, 1,
          cloud_of_points(walk.ros, {}, walk.stamp_ns(0), "cam_optical_frame", walk.points_of(0), 1));
  EXPECT_FALSE(is_sweep_recording(write(bag), {}));
}

TEST_F(LidarBag, IsNotGoneOverWhereItSaysThatThereAreNoClouds) {
  constexpr const char* kClouds = "sensor_msgs/PointCloud2";
  write_bytes(folder_ / "robot.bag", ros1_file(Robot{{true, true}}.bag().log()));
  EXPECT_FALSE(may_have_type(folder_ / "robot.bag", kClouds, {}));
  EXPECT_TRUE(may_have_type(folder_ / "robot.bag", "sensor_msgs/Image", {}));
  write(robot_bag(), "bag/robot_0.mcap");
  EXPECT_TRUE(may_have_type(folder_ / "bag/robot_0.mcap", kClouds, {})) << "it has no index";
  std::ofstream(folder_ / "bag/metadata.yaml") << "rosbag2_bagfile_information:\n  version: 5\n"
                                                  "  relative_file_paths:\n    - robot_0.mcap\n"
                                                  "  topics_with_message_count:\n    - topic_metadata:\n"
                                                  "        type: sensor_msgs/msg/Image\n";
  EXPECT_FALSE(may_have_type(folder_ / "bag/robot_0.mcap", kClouds, {}));
  EXPECT_FALSE(may_have_type(folder_ / "bag", kClouds, {}));
  write_bytes(folder_ / "torn.bag", unfinished_bag({}, "none"));
  EXPECT_TRUE(may_have_type(folder_ / "torn.bag", kClouds, {}));
}

/// A small cloud with every field.
Bytes small_cloud(bool is_ros1) {
  LidarWalk walk;
  walk.model = {.rings = 2, .columns = 3};
  return cloud_of_points({true, is_ros1}, {}, walk.stamp_ns(0), "lidar", walk.points_of(0), 1);
}

/// No more points than the cloud has, and as many rings and times as points, or none.
void expect_whole(const Sweep& sweep) {
  EXPECT_LE(sweep.points_m.size(), 6u);
  for (const Eigen::Vector3f& p : sweep.points_m) EXPECT_TRUE(p.allFinite());
  EXPECT_TRUE(sweep.rings.empty() || sweep.rings.size() == sweep.points_m.size());
  EXPECT_TRUE(sweep.offsets_ns.empty() || sweep.offsets_ns.size() == sweep.points_m.size());
}

TEST(CloudSweep, CutAnywhereIsAnError) {
  for (const bool is_ros1 : {false, true}) {
    const Bytes whole = small_cloud(is_ros1);
    const RosEncoding encoding = is_ros1 ? RosEncoding::kRos1 : RosEncoding::kCdr;
    const auto sweep = decode_cloud_sweep({whole, encoding}, LidarWalk::kBegin_ns, {});
    ASSERT_TRUE(sweep) << sweep.error().text();
    EXPECT_EQ(sweep->points_m.size(), 5u);
    EXPECT_EQ(sweep->rings.size(), 5u);
    EXPECT_EQ(sweep->offsets_ns.size(), 5u);
    for (std::size_t size = 0; size + 1 < whole.size(); ++size) {
      EXPECT_FALSE(decode_cloud_sweep({std::span(whole).first(size), encoding}, 0, {})) << size;
    }
  }
}

TEST(CloudSweep, ChangedAnywhereIsAnErrorOrWhole) {
  const Bytes whole = small_cloud(false);
  std::mt19937 random(7);
  const auto expect_sound = [](const Bytes& damaged) {
    if (const auto sweep = decode_cloud_sweep(damaged, LidarWalk::kBegin_ns, {})) expect_whole(*sweep);
  };
  for (std::size_t i = 0; i < whole.size(); ++i) {
    for (const int change : {0x01, 0x80, 0xFF}) {
      Bytes damaged = whole;
      damaged[i] ^= static_cast<std::byte>(change);
      expect_sound(damaged);
    }
  }
  for (int trial = 0; trial < 20'000; ++trial) {
    Bytes damaged = whole;
    for (int k = 0; k < 3; ++k) damaged[random() % damaged.size()] = static_cast<std::byte>(random());
    expect_sound(damaged);
  }
}

TEST(CloudSweep, LeavesOutWhatIsNoReturn) {
  std::vector<TimedPoint> points(6);
  points[0].p_sensor = {NAN, 0, 1};
  points[1].p_sensor = {1, HUGE_VALF, 1};
  points[2].p_sensor = {1e30F, 0, 0};
  points[3].p_sensor = {1, 2, 3};
  const auto sweep = decode_cloud_sweep(cloud_of_points({}, {}, 0, "l", points, 1), 0, {});
  ASSERT_TRUE(sweep);
  ASSERT_EQ(sweep->points_m.size(), 1u);
  EXPECT_EQ(sweep->points_m[0], Eigen::Vector3f(1, 2, 3));
}

TEST(CloudSweep, LeavesOutRingsAndTimesThatCannotBe) {
  std::vector<TimedPoint> points(3);
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i] = {{1, 2, 3}, 70'000, static_cast<std::int64_t>(i) * 3'000'000'000};  // a turn of six seconds
  }
  const CloudFormat format{.ring_type = kUint32Field};
  const auto sweep = decode_cloud_sweep(cloud_of_points({}, format, 0, "l", points, 1), 0, {});
  ASSERT_TRUE(sweep);
  EXPECT_EQ(sweep->points_m.size(), 3u);
  EXPECT_TRUE(sweep->rings.empty());
  EXPECT_TRUE(sweep->offsets_ns.empty());
}

TEST(CloudSweep, OfMorePointsThanTheLimitIsRefused) {
  Limits limits;
  limits.max_image_pixels = 5;
  EXPECT_FALSE(decode_cloud_sweep(small_cloud(false), 0, limits));
}

TEST_F(LidarBag, SurvivesAnyWrongByteAndAnyCut) {
  LidarWalk walk;
  walk.model = {.rings = 2, .columns = 3};
  walk.sweeps = 2;
  walk.tf_step_ns = 50'000'000;
  const Bytes whole = walk.bag().file(BagPacking::kNoChunk);  // without a checksum
  const auto sweeps_in = [](const Bytes& bytes) {
    auto messages = open_bag_file(std::make_unique<MemoryAccess>(bytes), "a.mcap", {});
    if (!messages) return std::size_t{0};
    const auto source = index_bag_sweeps({*std::move(messages)}, "a.mcap", {});
    std::size_t read = 0;
    for (std::size_t i = 0; source && i < (*source)->info().sweeps; ++i) {
      const auto event = (*source)->read(i);
      const auto* sweep = std::get_if<Sweep>(&event);
      if (sweep == nullptr) continue;
      expect_whole(*sweep);
      ++read;
    }
    return read;
  };
  EXPECT_EQ(sweeps_in(whole), 2u);
  for (std::size_t i = 0; i < whole.size(); ++i) {
    Bytes damaged = whole;
    damaged[i] ^= std::byte{0xFF};
    EXPECT_LE(sweeps_in(damaged), 2u);
    EXPECT_LE(sweeps_in(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(i))), 2u);
  }
}

// What ROS 1's own library writes: a wall of points at x = 4 m, seen while the scanner goes a metre along x.
TEST_F(LidarBag, IsReadAsRosbagWritesIt) {
  const std::string file = (folder_ / "wall.bag").string();
  const std::string command = "/usr/bin/python3 '" + kSourceDir + "/tests/acquire/write_lidar_bag.py' '" + file + "'";
  const int status = std::system(command.c_str());  // NOLINT(concurrency-mt-unsafe): one thread
  constexpr int kSkipped = 77, kNoSuchCommand = 127;
  if (WEXITSTATUS(status) == kSkipped || WEXITSTATUS(status) == kNoSuchCommand) {
    GTEST_SKIP() << "SKIPPED: python3-rosbag, python3-sensor-msgs or python3-tf2-msgs is not installed";
  }
  ASSERT_EQ(status, 0) << command;
  const auto source = opened(file);
  ASSERT_NE(source, nullptr);
  ASSERT_EQ(source->info().sweeps_with_pose, 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto event = source->read(i);
    const auto* sweep = std::get_if<Sweep>(&event);
    ASSERT_NE(sweep, nullptr);
    ASSERT_EQ(sweep->points_m.size(), 64u);
    for (const Eigen::Vector3f& p : sweep->points_m) {
      EXPECT_NEAR((sweep->T_world_sensor * p.cast<double>()).x(), 4, 1e-4);
    }
  }
}

}  // namespace
}  // namespace scanknit::test
