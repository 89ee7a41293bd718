// Bags of ROS 2: which topics are read, by name, and point clouds as depth.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "acquire/ros2/ros2_cloud.h"
#include "robot_frames.h"
#include "ros2_bag.h"
#include "test_replay_support.h"
#include "tests/support/text.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;

AcquireConfig still_with(const BagTopics& topics) {
  AcquireConfig config;
  config.poses = PoseMode::kStill;
  config.topics = topics;
  return config;
}

class BagTopicChoice : public ::testing::Test {
 protected:
  void write(const Ros2Bag& bag) const { write_bytes(folder_ / "bag.mcap", bag.file()); }
  [[nodiscard]] RecordingInfo described(const AcquireConfig& config = {}) const {
    const auto source = open_recording(folder_ / "bag.mcap", config);
    EXPECT_TRUE(source) << source.error().text();
    return source ? (*source)->info() : RecordingInfo{};
  }
  [[nodiscard]] Played played(const AcquireConfig& config = {}) const { return play(folder_ / "bag.mcap", config); }
  [[nodiscard]] std::string refused(const AcquireConfig& config = {}) const {
    return open_error(folder_ / "bag.mcap", config);
  }

  TemporaryFolder folder_;
  Ros2Writer ros_;
};

/// A second camera, of which everything has another name.
Ros2Bag two_cameras() {
  const Ros2Writer ros;
  Ros2Bag bag = robot_bag();
  bag.add("/left/aligned/image_raw", kImageType, 7, ros.image(7, "left", "16UC1", 4, 2, counted_depth(500, 8)));
  bag.add("/left/rgb", kImageType, 7, ros.image(7, "left", "rgb8", 4, 2, Bytes(24, std::byte{9})));
  bag.add("/left/info", kCameraType, 7, ros.camera(4, 2, {6, 6, 1.5, 0.5}));
  bag.add("/left/rgb_info", kCameraType, 7, ros.camera(4, 2, {7, 7, 1.5, 0.5}));
  bag.add("/left/pose", "geometry_msgs/msg/PoseStamped", 7, ros.pose(7, "map", {0, 4, 0, 0, 0, 0, 1}));
  return bag;
}

TEST_F(BagTopicChoice, TakesWhatIsNamed) {
  write(two_cameras());
  AcquireConfig config;
  config.topics = {"/left/aligned/image_raw", "/left/rgb", "/left/info", "/left/rgb_info", "/left/pose"};
  const Played p = played(config);
  ASSERT_EQ(p.frames.size(), 1u);
  const Frame& frame = p.frames[0];
  EXPECT_EQ(frame.depth_m.at(0, 0), 0.5F);
  EXPECT_EQ(frame.intrinsics.fx, 6);
  ASSERT_TRUE(frame.colour);
  EXPECT_EQ(frame.colour->image.at(0, 0), (Rgb8{9, 9, 9}));
  EXPECT_EQ(frame.colour->intrinsics.fx, 7);
  EXPECT_TRUE(frame.T_world_camera->translation().isApprox(Eigen::Vector3d(0, 4, 0)));
  EXPECT_EQ(described(config).topics.at("not_read"), "/cam/color/image_raw, /cam/depth/image_raw");
}

TEST_F(BagTopicChoice, KeepsItsOwnWhereNothingIsNamed) {
  write(two_cameras());
  expect_robot(played());
  EXPECT_EQ(described().topics.at("not_read"), "/left/aligned/image_raw, /left/rgb");
}

TEST_F(BagTopicChoice, LeavesColourOutForNone) {
  write(robot_bag());
  EXPECT_FALSE(played(still_with({.colour = "none"})).frames.at(0).colour);
}

TEST_F(BagTopicChoice, ListsTheTopicsThatThereAre) {
  write(two_cameras());
  EXPECT_TRUE(contains(refused(still_with({.depth = "/x"})),
                       "acquire.topics.depth: the bag has no topic '/x' of depth; it has /cam/depth/image_raw, "
                       "/left/aligned/image_raw"));
  EXPECT_TRUE(contains(refused(still_with({.colour = "/cam/depth/image_raw"})),
                       "of colour; it has /cam/color/image_raw, /left/rgb"));
  EXPECT_TRUE(contains(refused(still_with({.depth_camera = "/x"})), "CameraInfo; it has /cam/color/camera_info, "));
  EXPECT_TRUE(contains(refused(still_with({.colour_camera = "/x"})), "acquire.topics.colour_camera"));
  EXPECT_TRUE(contains(refused(still_with({.poses = "/x"})), "PoseStamped; it has /left/pose"));
}

using CloudPoints = std::vector<std::tuple<float, float, float, std::uint32_t>>;

constexpr int kCloudWidth = 6, kCloudHeight = 5;
const CameraIntrinsics kCloudCamera{kCloudWidth, kCloudHeight, 8, 9, 2.5, 1.75};

/// What a camera sees of a slanted plane; one pixel without a return.
CloudPoints seen_points(const CameraIntrinsics& camera = kCloudCamera) {
  CloudPoints points;
  for (int v = 0; v < kCloudHeight; ++v) {
    for (int u = 0; u < kCloudWidth; ++u) {
      const Eigen::Vector3d p = camera.unproject(u, v, 1 + 0.125 * u + 0.0625 * v);
      points.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()),
                          static_cast<std::uint32_t>(u << 16 | v << 8 | 7));
    }
  }
  std::get<2>(points[1]) = std::nanf("");
  return points;
}

void expect_seen(const Frame& frame) {
  EXPECT_EQ(frame.depth_m.width(), kCloudWidth);
  EXPECT_EQ(frame.depth_m.at(0, 0), 1.0F);
  EXPECT_EQ(frame.depth_m.at(1, 0), 0.0F);
  EXPECT_EQ(frame.depth_m.at(5, 4), 1.875F);
  constexpr double kFloatRounding = 1e-5;
  EXPECT_NEAR(frame.intrinsics.fx, kCloudCamera.fx, kFloatRounding);
  EXPECT_NEAR(frame.intrinsics.fy, kCloudCamera.fy, kFloatRounding);
  EXPECT_NEAR(frame.intrinsics.cx, kCloudCamera.cx, kFloatRounding);
  EXPECT_NEAR(frame.intrinsics.cy, kCloudCamera.cy, kFloatRounding);
  ASSERT_TRUE(frame.colour);
  EXPECT_EQ(frame.colour->image.at(5, 4), (Rgb8{5, 4, 7}));
}

TEST_F(BagTopicChoice, ReadsOrganisedCloudsAsDepth) {
  for (const bool is_big_endian : {false, true}) {
    Ros2Bag bag;
    bag.add("/cam/points", kCloudType, 1,
            ros_.cloud(1, "cam", kCloudWidth, kCloudHeight, seen_points(), is_big_endian));
    write(bag);
    const Played p = played(still_with({}));
    ASSERT_EQ(p.frames.size(), 1u);
    expect_seen(p.frames[0]);
    EXPECT_EQ(described(still_with({})).topics.at("depth"), "/cam/points");
  }
}

TEST_F(BagTopicChoice, TakesACloudsCameraFromCameraInfo) {
  Ros2Bag bag;
  bag.add("/cam/points", kCloudType, 1, ros_.cloud(1, "cam", kCloudWidth, kCloudHeight, seen_points()));
  bag.add("/cam/camera_info", kCameraType, 1, ros_.camera(kCloudWidth, kCloudHeight, {4, 4.5, 2.5, 1.75}));
  write(bag);
  EXPECT_EQ(played(still_with({})).frames.at(0).intrinsics, kCloudCamera) << "the matrix P, twice K";
}

TEST_F(BagTopicChoice, PrefersPicturesToClouds) {
  Ros2Bag bag = robot_bag();
  for (int i = 0; i < 9; ++i) {
    bag.add("/cam/points", kCloudType, 1, ros_.cloud(i, "cam", kCloudWidth, kCloudHeight, seen_points()));
  }
  write(bag);
  expect_robot(played());
  expect_seen(played(still_with({.depth = "/cam/points"})).frames.at(0));
}

TEST_F(BagTopicChoice, SaysThatUnorganisedCloudsAreSweeps) {
  Ros2Bag bag;
  bag.add("/lidar", kCloudType, 1, ros_.cloud(1, "l", kCloudWidth * kCloudHeight, 1, seen_points()));
  write(bag);
  for (const auto& config : {still_with({}), still_with({.depth = "/lidar"})}) {
    EXPECT_TRUE(contains(refused(config), "the clouds of /lidar are LiDAR sweeps")) << refused(config);
  }
}

TEST_F(BagTopicChoice, DropsACloudThatIsNoCamerasPicture) {
  CloudPoints points = seen_points();
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i] = {static_cast<float>(i * 7 % 11), static_cast<float>(i * 5 % 13), 1.0F + static_cast<float>(i % 3), 0};
  }
  Ros2Bag bag;
  bag.add("/points", kCloudType, 1, ros_.cloud(1, "l", kCloudWidth, kCloudHeight, points));
  write(bag);
  const Played p = played(still_with({}));
  ASSERT_EQ(p.dropped.size(), 1u);
  EXPECT_TRUE(contains(p.dropped[0].error.message, "it is no camera's picture"));
}

TEST(Ros2Cloud, CutOrChangedAnywhereIsRefusedOrWithinItsSize) {
  const Bytes whole = Ros2Writer{}.cloud(1, "c", kCloudWidth, kCloudHeight, seen_points());
  ASSERT_TRUE(decode_ros2_cloud(whole, {}));
  for (std::size_t size = 0; size + 1 < whole.size(); ++size) {
    EXPECT_FALSE(decode_ros2_cloud(std::span(whole).first(size), {})) << size;
  }
  for (std::size_t i = 0; i < whole.size(); ++i) {
    for (const int change : {0x01, 0x80, 0xFF}) {
      Bytes damaged = whole;
      damaged[i] ^= static_cast<std::byte>(change);
      (void)decode_ros2_cloud(damaged, {});
    }
  }
}

}  // namespace
}  // namespace scanknit::test
