// A real phone's recording, laid out as each of the phones' layouts has it: the frames stay the same.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "acquire/parse/opengl_pose.h"
#include "test_replay_support.h"
#include "zip_writer.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;

constexpr double kSensorWidth = 1920, kSensorHeight = 1440;

/// Three frames of a corridor, with their files.
class RealPhone : public ::testing::Test {
 protected:
  void SetUp() override {
    const fs::path real = data_folder() / "rgbd_iphone_lidar_corridor_73";
    if (!fs::exists(real)) GTEST_SKIP() << "SKIPPED: no recording of a phone to read";
    for (const int number : {0, 6, 12}) {
      for (const char* pattern : {"depth_{:05}.png", "conf_{:05}.png", "frame_{:05}.jpg", "frame_{:05}.json"}) {
        const std::string name = fmt::format(fmt::runtime(pattern), number);
        fs::create_directories(folder_ / "source");
        fs::copy(real / name, folder_ / "source" / name);
      }
    }
    source_ = play(folder_ / "source");
    ASSERT_EQ(source_.frames.size(), 3u);
  }

  /// "depth", "conf" or "frame" of a frame.
  [[nodiscard]] fs::path file(const Frame& frame, const char* kind, const char* end = ".png") const {
    return folder_ / "source" / fmt::format("{}_{:05}{}", kind, frame.sequence, end);
  }
  void copy(const fs::path& from, const fs::path& to) const {
    fs::create_directories(to.parent_path());
    fs::copy(from, to);
  }
  /// The camera of the full picture, from which the source's was scaled.
  static CameraIntrinsics sensor(const Frame& frame) {
    const double scale = kSensorWidth / frame.intrinsics.width;
    const CameraIntrinsics& k = frame.intrinsics;
    return {static_cast<int>(kSensorWidth),
            static_cast<int>(kSensorHeight),
            k.fx * scale,
            k.fy * scale,
            k.cx * scale,
            k.cy * scale};
  }
  /// The app's layout holds what the source holds; cameras count half a pixel otherwise (docs/recordings.md).
  void expect_same(const fs::path& place, const char* format) const {
    auto source = open_recording(place, {});
    ASSERT_TRUE(source) << source.error().text();
    EXPECT_EQ((*source)->info().format, format);
    const Played played = play(**source);
    for (const FrameDropped& drop : played.dropped) ADD_FAILURE() << drop.error.text();
    ASSERT_EQ(played.frames.size(), source_.frames.size());
    for (std::size_t i = 0; i < played.frames.size(); ++i) {
      const Frame& frame = played.frames[i];
      const Frame& expected = source_.frames[i];
      EXPECT_EQ(frame.depth_m, expected.depth_m) << i;
      EXPECT_TRUE(frame.T_world_camera->isApprox(*expected.T_world_camera, 1e-6)) << i;
      EXPECT_NEAR(frame.intrinsics.fx, expected.intrinsics.fx, 1e-6);
      EXPECT_NEAR(frame.intrinsics.cx, expected.intrinsics.cx, 0.5);
      constexpr double kMicroseconds = 1000;  // to which Polycam's names are rounded
      EXPECT_NEAR(static_cast<double>(frame.timestamp_ns - expected.timestamp_ns), 0, kMicroseconds);
      EXPECT_EQ(frame.colour.value().image, expected.colour.value().image);
      EXPECT_NEAR(frame.colour->intrinsics.fx, expected.colour->intrinsics.fx, 1e-6);
    }
  }

  TemporaryFolder folder_;
  Played source_;
};

TEST_F(RealPhone, IsTheSameAsStrayScannerHasIt) {
  std::string odometry = "timestamp, frame, x, y, z, qx, qy, qz, qw, fx, fy, cx, cy\n";
  for (std::size_t i = 0; i < source_.frames.size(); ++i) {
    const Frame& frame = source_.frames[i];
    const std::string name = fmt::format("{:06}", i);
    copy(file(frame, "depth"), folder_ / "stray/depth" / (name + ".png"));
    copy(file(frame, "conf"), folder_ / "stray/confidence" / (name + ".png"));
    copy(file(frame, "frame", ".jpg"), folder_ / "stray/rgb" / (name + ".jpg"));
    const Eigen::Vector3d t = frame.T_world_camera->translation();
    const Eigen::Quaterniond q(frame.T_world_camera->linear());
    const CameraIntrinsics k = sensor(frame);
    odometry += fmt::format("{}.{:09}, {}, {}, {}, {}, {}, {}, {}, {}, {}, {}, {}, {}\n",
                            frame.timestamp_ns / 1'000'000'000, frame.timestamp_ns % 1'000'000'000, name, t.x(), t.y(),
                            t.z(), q.x(), q.y(), q.z(), q.w(), k.fx, k.fy, k.cx, k.cy);
  }
  write_text(folder_ / "stray/odometry.csv", odometry);
  expect_same(folder_ / "stray", "stray-scanner");
}

TEST_F(RealPhone, IsTheSameAsPolycamHasIt) {
  for (const Frame& frame : source_.frames) {
    const std::string name = std::to_string(frame.timestamp_ns / 1000);
    const fs::path keyframes = folder_ / "polycam/keyframes";
    copy(file(frame, "depth"), keyframes / "depth" / (name + ".png"));
    copy(file(frame, "frame", ".jpg"), keyframes / "images" / (name + ".jpg"));
    cv::Mat confidence = cv::imread(file(frame, "conf").string(), cv::IMREAD_UNCHANGED);
    confidence.forEach<std::uint8_t>([](std::uint8_t& level, const int*) { level = level == 2 ? 255 : level * 127; });
    fs::create_directories(keyframes / "confidence");
    ASSERT_TRUE(cv::imwrite((keyframes / "confidence" / (name + ".png")).string(), confidence));
    const CameraIntrinsics k = sensor(frame);
    nlohmann::json camera = {{"fx", k.fx}, {"fy", k.fy}, {"cx", k.cx}, {"cy", k.cy}, {"width", 1920}, {"height", 1440}};
    const Eigen::Matrix4d arkit = opengl_matrix(*frame.T_world_camera);
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) camera[fmt::format("t_{}{}", row, column)] = arkit(row, column);
    }
    write_text(keyframes / "cameras" / (name + ".json"), camera.dump());
  }
  expect_same(folder_ / "polycam", "polycam");
}

TEST_F(RealPhone, IsTheSameAsRecord3dHasIt) {
  nlohmann::json metadata = {{"w", 1920}, {"h", 1440}, {"dw", 256}, {"dh", 192}, {"fps", 10}};
  ZipWriter writer;
  for (std::size_t i = 0; i < source_.frames.size(); ++i) {
    const Frame& frame = source_.frames[i];
    const std::string name = "rgbd/" + std::to_string(i);
    std::vector<std::byte> depth;
    for (const float z : frame.depth_m.pixels()) ByteAppender(depth).little_endian(z);
    writer.add(name + ".depth", plain_lzfse(depth));
    writer.add(name + ".jpg", bytes_of(file(frame, "frame", ".jpg")));
    const CameraIntrinsics k = sensor(frame);
    metadata["perFrameIntrinsicCoeffs"].push_back({k.fx, k.fy, k.cx, k.cy});
    metadata["frameTimestamps"].push_back(static_cast<double>(frame.timestamp_ns) / 1e9);
    const Eigen::Matrix4d arkit = opengl_matrix(*frame.T_world_camera);
    const Eigen::Quaterniond q(Eigen::Matrix3d(arkit.topLeftCorner<3, 3>()));
    metadata["poses"].push_back({q.x(), q.y(), q.z(), q.w(), arkit(0, 3), arkit(1, 3), arkit(2, 3)});
  }
  const std::string text = metadata.dump();
  const auto bytes = std::as_bytes(std::span(text));
  writer.add("metadata", {bytes.begin(), bytes.end()});
  write_bytes(folder_ / "scan.r3d", writer.whole());
  expect_same(folder_ / "scan.r3d", "record3d");
}

}  // namespace
}  // namespace scanknit::test
