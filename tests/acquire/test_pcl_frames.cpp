// What is read and cleaned through PCL: organised PCD, PCLZF, statistical outliers.
#include <gtest/gtest.h>
#include <pcl/io/lzf_image_io.h>
#include <pcl/io/pcd_io.h>
#include <pcl/point_types.h>

#include <limits>

#include "acquire/filter/outlier_filter.h"
#include "acquire/pcl/pcd_header.h"
#include "test_replay_support.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;
using Reasons = std::vector<std::string>;

const CameraIntrinsics kCamera{kWidth, kHeight, 100, 110, 3.2, 2.4};

// A slanted wall, one pixel of which is no return.
pcl::PointCloud<pcl::PointXYZRGB> wall() {
  pcl::PointCloud<pcl::PointXYZRGB> cloud(kWidth, kHeight);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      auto& point = cloud.at(u, v);
      point.getVector3fMap() = kCamera.unproject(u, v, 1.0 + 0.01 * u).cast<float>();
      point.r = 200;
      point.g = 100;
      point.b = 50;
    }
  }
  cloud.at(2, 1).getVector3fMap().setConstant(std::numeric_limits<float>::quiet_NaN());
  cloud.sensor_origin_ = Eigen::Vector4f(1, 2, 3, 0);
  return cloud;
}

void expect_wall(const fs::path& path) {
  const Frame frame = play(path).frames.at(0);
  EXPECT_NEAR(frame.depth_m.at(5, 3), 1.05, 1e-6);
  EXPECT_EQ(frame.depth_m.at(2, 1), 0.0F);
  EXPECT_EQ(frame.colour->image.at(5, 3), (Rgb8{200, 100, 50}));
  constexpr double kFloatPixels = 1e-3;  // float coordinates over 0.01 of slope a pixel
  EXPECT_NEAR(frame.intrinsics.fx, kCamera.fx, kFloatPixels);
  EXPECT_NEAR(frame.intrinsics.fy, kCamera.fy, kFloatPixels);
  EXPECT_NEAR(frame.intrinsics.cx, kCamera.cx, kFloatPixels);
  EXPECT_NEAR(frame.intrinsics.cy, kCamera.cy, kFloatPixels);
  EXPECT_TRUE(frame.T_world_camera->translation().isApprox(Eigen::Vector3d(1, 2, 3)));
}

TEST(OrganisedPcd, IsReadWhenBinary) {
  const TemporaryFolder folder;
  pcl::io::savePCDFileBinary((folder / "a.pcd").string(), wall());
  expect_wall(folder / "a.pcd");
}

TEST(OrganisedPcd, IsReadWhenCompressed) {
  const TemporaryFolder folder;
  pcl::io::savePCDFileBinaryCompressed((folder / "a.pcd").string(), wall());
  expect_wall(folder / "a.pcd");
}

TEST(OrganisedPcd, IsReadWhenText) {
  const TemporaryFolder folder;
  pcl::PCDWriter().writeASCII((folder / "a.pcd").string(), wall(), 9);
  expect_wall(folder / "a.pcd");
}

TEST(OrganisedPcd, OfAFolderIsPlayedInNaturalOrder) {
  const TemporaryFolder folder;
  for (const int number : {10, 2, 1}) {
    auto cloud = wall();
    cloud.sensor_origin_.x() = static_cast<float>(number);
    pcl::io::savePCDFileBinary((folder / ("c" + std::to_string(number) + ".pcd")).string(), cloud);
  }
  const Played played = play(folder.path());
  ASSERT_EQ(played.frames.size(), 3u);
  EXPECT_EQ(played.frames[2].T_world_camera->translation().x(), 10);
}

TEST(OrganisedPcd, ThatIsUnorganisedIsRefusedClearly) {
  const TemporaryFolder folder;
  auto cloud = wall();
  cloud.width *= cloud.height;
  cloud.height = 1;
  pcl::io::savePCDFileBinary((folder / "a.pcd").string(), cloud);
  const Played played = play(folder.path());
  ASSERT_EQ(played.reasons(), Reasons{"unreadable"});
  EXPECT_NE(played.dropped[0].error.message.find("not organised"), std::string::npos);
}

TEST(OrganisedPcd, WhosePointsAreNoPictureHasNoCamera) {
  const TemporaryFolder folder;
  auto cloud = wall();
  for (std::size_t i = 0; i < cloud.size(); ++i) cloud[i].x = static_cast<float>(i * 7919 % 31);
  pcl::io::savePCDFileBinary((folder / "a.pcd").string(), cloud);
  EXPECT_EQ(play(folder.path()).reasons(), Reasons{"no_intrinsics"});
}

void expect_refused_when_cut(const fs::path& file) {
  const auto whole = bytes_of(file);
  const TemporaryFolder folder;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    write_bytes(folder / "cut.pcd", {whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)});
    EXPECT_EQ(play(folder.path()).reasons(), Reasons{"unreadable"}) << "cut at " << size;
  }
}

TEST(OrganisedPcd, IsRefusedWhenBinaryIsCutAtAnyByte) {
  const TemporaryFolder folder;
  pcl::io::savePCDFileBinary((folder / "a.pcd").string(), wall());
  expect_refused_when_cut(folder / "a.pcd");
}

TEST(OrganisedPcd, IsRefusedWhenCompressedIsCutAtAnyByte) {
  const TemporaryFolder folder;
  pcl::io::savePCDFileBinaryCompressed((folder / "a.pcd").string(), wall());
  expect_refused_when_cut(folder / "a.pcd");
}

TEST(OrganisedPcd, SurvivesAnyWrongByte) {
  const TemporaryFolder folder;
  pcl::io::savePCDFileBinaryCompressed((folder / "a.pcd").string(), wall());
  const auto whole = bytes_of(folder / "a.pcd");
  for (std::size_t i = 0; i < whole.size(); ++i) {
    auto bytes = whole;
    bytes[i] ^= std::byte{0x15};
    write_bytes(folder / "a.pcd", bytes);
    const Played played = play(folder.path());
    EXPECT_EQ(played.frames.size() + played.dropped.size(), 1u) << "byte " << i;
  }
}

Result<PcdHeader> header_of(const std::string& text) {
  return parse_pcd_header(std::as_bytes(std::span(text)), Limits{});
}

TEST(PcdHeader, RefusesSizesBeyondTheLimits) {
  const std::string fields = "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n";
  EXPECT_FALSE(header_of(fields + "WIDTH 999999999\nHEIGHT 999999999\nPOINTS 1\nDATA binary\n"));
  EXPECT_FALSE(header_of(fields + "WIDTH 60000000\nHEIGHT 60000000\nDATA binary\n"));
  EXPECT_FALSE(header_of(fields + "WIDTH -4\nHEIGHT 4\nPOINTS 16\nDATA ascii\n"));
}

TEST(PcdHeader, RefusesFieldsThatDoNotMatch) {
  EXPECT_FALSE(header_of("FIELDS x y z\nSIZE 4 4\nTYPE F F F\nWIDTH 1\nHEIGHT 1\nDATA ascii\n1 2 3\n"));
  EXPECT_FALSE(header_of("FIELDS x y z\nSIZE 4 4 3\nTYPE F F F\nWIDTH 1\nHEIGHT 1\nDATA ascii\n1 2 3\n"));
  EXPECT_FALSE(header_of("SIZE 4\nFIELDS x\nTYPE F\nWIDTH 1\nHEIGHT 1\nDATA ascii\n1\n"));
}

constexpr const char* kParameters =
    "<depth><focal_length_x>525</focal_length_x><focal_length_y>526</focal_length_y>"
    "<principal_point_x>4</principal_point_x><principal_point_y>3</principal_point_y>"
    "<z_multiplication_factor>0.001</z_multiplication_factor></depth>"
    "<rgb><focal_length_x>500</focal_length_x><focal_length_y>501</focal_length_y>"
    "<principal_point_x>4</principal_point_x><principal_point_y>3</principal_point_y></rgb>";

class PclzfFrame : public ::testing::Test {
 protected:
  void SetUp() override {
    std::vector<std::uint16_t> depth(kWidth * kHeight, 1250);
    depth[9] = 0;
    pcl::io::LZFDepth16ImageWriter().write(reinterpret_cast<const char*>(depth.data()), kWidth, kHeight,
                                           (folder_ / "f_depth.pclzf").string());
    std::vector<char> colour;
    for (int i = 0; i < kWidth * kHeight; ++i) colour.insert(colour.end(), {10, 20, 30});
    pcl::io::LZFRGB24ImageWriter().write(colour.data(), kWidth, kHeight, (folder_ / "f_rgb.pclzf").string());
    write_text(folder_ / "f.xml", kParameters);
  }
  [[nodiscard]] static AcquireConfig still() {
    AcquireConfig config;
    config.poses = PoseMode::kStill;
    return config;
  }
  // The frame under another name, without its colour.
  [[nodiscard]] Frame play_as(const std::string& stem) const {
    const TemporaryFolder renamed;
    fs::copy_file(folder_ / "f_depth.pclzf", renamed / (stem + "_depth.pclzf"));
    fs::copy_file(folder_ / "f.xml", renamed / (stem + ".xml"));
    return play(renamed.path(), still()).frames.at(0);
  }
  TemporaryFolder folder_;
};

TEST_F(PclzfFrame, TakesItsTimeFromItsName) {
  const Frame frame = play_as("frame_20121214T142255.814212");
  EXPECT_TRUE(frame.has_clock);
  EXPECT_EQ(frame.timestamp_ns, 1'355'494'975'814'212'000);  // date -u -d '2012-12-14 14:22:55' +%s
}

TEST_F(PclzfFrame, HasNoClockWhenItsNameIsNoTimeThatFits) {
  for (const char* stem : {"f_99991231T235959.5", "f_00010101T000000.5", "f_+inf0101T000000.5", "f_9e990101T000000.5",
                           "f_20121301T000000.5", "f_20120101T240000.5", "f_20120101T00009000000000"}) {
    EXPECT_FALSE(play_as(stem).has_clock) << stem;
  }
}

TEST_F(PclzfFrame, IsReadWithBothCameras) {
  const Frame frame = play(folder_.path(), still()).frames.at(0);
  EXPECT_EQ(frame.intrinsics, (CameraIntrinsics{kWidth, kHeight, 525, 526, 4, 3}));
  EXPECT_EQ(frame.colour->intrinsics, (CameraIntrinsics{kWidth, kHeight, 500, 501, 4, 3}));
  EXPECT_EQ(frame.colour->image.at(3, 3), (Rgb8{10, 20, 30}));
  EXPECT_FLOAT_EQ(frame.depth_m.at(0, 0), 1.25F);
  EXPECT_EQ(frame.depth_m.at(1, 1), 0.0F);
}

TEST_F(PclzfFrame, HasNoPoseOfItsOwn) {
  AcquireConfig config;
  config.poses = PoseMode::kRecording;
  EXPECT_EQ(play(folder_.path(), config).reasons(), Reasons{"no_pose"});
}

TEST_F(PclzfFrame, IsToBeTracked) {
  const auto source = open_recording(folder_.path(), {});
  ASSERT_TRUE(source);
  EXPECT_EQ((*source)->info().poses, PoseMode::kTrack);
  const Played played = play(**source);
  ASSERT_EQ(played.frames.size(), 1u);
  EXPECT_FALSE(played.frames[0].T_world_camera.has_value());
}

TEST_F(PclzfFrame, IsOpenedByItsDepthFile) {
  EXPECT_EQ(play(folder_ / "f_depth.pclzf", still()).frames.size(), 1u);
}

TEST_F(PclzfFrame, IsRefusedWhenCutAtAnyByte) {
  for (const char* name : {"f_depth.pclzf", "f_rgb.pclzf"}) {
    const auto whole = bytes_of(folder_ / name);
    for (std::size_t size = 0; size < whole.size(); ++size) {
      write_bytes(folder_ / name, {whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)});
      EXPECT_EQ(play(folder_.path(), still()).reasons(), Reasons{"unreadable"}) << name << " cut at " << size;
    }
    write_bytes(folder_ / name, whole);
  }
}

TEST_F(PclzfFrame, SurvivesAnyWrongByte) {
  const auto whole = bytes_of(folder_ / "f_depth.pclzf");
  for (std::size_t i = 0; i < whole.size(); ++i) {
    auto bytes = whole;
    bytes[i] ^= std::byte{0x81};
    write_bytes(folder_ / "f_depth.pclzf", bytes);
    const Played played = play(folder_.path(), still());
    EXPECT_EQ(played.frames.size() + played.dropped.size(), 1u) << "byte " << i;
  }
}

TEST_F(PclzfFrame, WithoutParametersHasNoIntrinsics) {
  fs::remove(folder_ / "f.xml");
  EXPECT_EQ(play(folder_.path(), still()).reasons(), Reasons{"no_intrinsics"});
}

TEST_F(PclzfFrame, WithBrokenParametersHasNoIntrinsics) {
  write_text(folder_ / "f.xml", "<depth><focal_length_x>525</dep");
  EXPECT_EQ(play(folder_.path(), still()).reasons(), Reasons{"no_intrinsics"});
}

TEST(StatisticalOutliers, LoseTheLonePointAndKeepTheWall) {
  const CameraIntrinsics camera{40, 30, 50, 50, 19.5, 14.5};
  DepthImage depth_m(40, 30, 1.0F);
  depth_m.at(20, 15) = 0.3F;
  const auto cleaned = remove_statistical_outliers(depth_m, camera, 8, 3.0);
  ASSERT_TRUE(cleaned) << cleaned.error().text();
  EXPECT_EQ(cleaned->at(20, 15), 0.0F);
  EXPECT_EQ(cleaned->at(10, 15), 1.0F);
}

TEST(StatisticalOutliers, OfNoNeighboursChangeNothing) {
  const DepthImage depth_m(4, 3, 1.0F);
  EXPECT_EQ(remove_statistical_outliers(depth_m, {4, 3, 5, 5, 2, 1}, 0, 1.0).value(), depth_m);
  EXPECT_EQ(remove_statistical_outliers(depth_m, {4, 3, 5, 5, 2, 1}, 100, 1.0).value(), depth_m);
}

}  // namespace
}  // namespace scanknit::test
