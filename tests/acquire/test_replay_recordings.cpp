// The real recordings of ../shared/data: what is in them is known.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "acquire/filter/depth_filter.h"
#include "test_replay_support.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;

struct Expected {
  const char* folder;
  const char* format;
  std::size_t frames;
  int width, height;
  int colour_width, colour_height;
  double fx;
  double min_median_m, max_median_m;  // of any frame's depth
};

std::ostream& operator<<(std::ostream& out, const Expected& expected) {
  return out << expected.folder;
}

float median_depth_m(const DepthImage& depth_m) {
  std::vector<float> valid;
  std::copy_if(depth_m.pixels().begin(), depth_m.pixels().end(), std::back_inserter(valid),
               [](float z) { return z > 0; });
  std::nth_element(valid.begin(), valid.begin() + static_cast<std::ptrdiff_t>(valid.size() / 2), valid.end());
  return valid[valid.size() / 2];
}

AcquireConfig config_for(const std::string& folder) {
  AcquireConfig config;
  if (folder == "rgbd_icl_3") config.intrinsics = CameraModel{{0, 0, 481.2, -480, 319.5, 239.5}, {}};
  if (folder == "pclzf") config.poses = PoseMode::kStill;
  return config;
}

class RealRecording : public ::testing::TestWithParam<Expected> {};

TEST_P(RealRecording, IsReadWhole) {
  const Expected& expected = GetParam();
  const fs::path folder = data_folder() / expected.folder;
  if (!fs::exists(folder)) GTEST_SKIP() << "SKIPPED: no " << expected.folder << " to read";
  auto source = open_recording(folder, config_for(expected.folder));
  ASSERT_TRUE(source) << source.error().text();
  EXPECT_EQ((*source)->info().format, expected.format);
  EXPECT_EQ((*source)->info().frames, expected.frames);
  EXPECT_NEAR((*source)->info().intrinsics->fx, expected.fx, 0.01);
  const Played played = play(**source);
  EXPECT_EQ(played.frames.size(), expected.frames);
  for (const FrameDropped& drop : played.dropped) ADD_FAILURE() << drop.error.text();
  for (const Frame& frame : played.frames) {
    EXPECT_EQ(frame.depth_m.width(), expected.width);
    EXPECT_EQ(frame.depth_m.height(), expected.height);
    ASSERT_TRUE(frame.colour.has_value());
    EXPECT_EQ(frame.colour->image.width(), expected.colour_width);
    EXPECT_EQ(frame.colour->image.height(), expected.colour_height);
    EXPECT_TRUE(is_rigid(frame.T_world_camera.value()));
    EXPECT_GT(median_depth_m(frame.depth_m), expected.min_median_m);
    EXPECT_LT(median_depth_m(frame.depth_m), expected.max_median_m);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Shared, RealRecording,
    ::testing::Values(Expected{"rgbd_box_f200", "7-scenes", 50, 640, 480, 640, 480, 615.195, 0.3, 0.9},
                      Expected{"rgbd_redwood_lr1_211", "open3d", 211, 640, 480, 640, 480, 525, 1.0, 4.0},
                      Expected{"rgbd_iphone_lidar_corridor_73", "phone-lidar", 73, 256, 192, 960, 720, 212.027, 0.3,
                               5.0},
                      Expected{"rgbd_icl_3", "tum", 3, 640, 480, 640, 480, 481.2, 1.0, 4.0},
                      Expected{"rgbd_sun3d_studyroom_5", "7-scenes", 5, 640, 480, 640, 480, 570.342, 0.5, 4.0},
                      Expected{"pclzf", "pclzf", 3, 640, 480, 640, 480, 525, 0.5, 4.0}));

// Median distance between one frame's depth and another's warped into it: what poses, axes and cameras share.
double median_warp_m(const Frame& from, const Frame& to) {
  const Pose T_to_from = to.T_world_camera->inverse() * *from.T_world_camera;
  std::vector<double> distances;
  for (int y = 0; y < from.depth_m.height(); y += 2) {
    for (int x = 0; x < from.depth_m.width(); x += 2) {
      if (!(from.depth_m.at(x, y) > 0)) continue;
      const Eigen::Vector3d p = T_to_from * from.intrinsics.unproject(x, y, from.depth_m.at(x, y));
      if (!(p.z() > 0)) continue;
      const Eigen::Vector2d pixel = to.intrinsics.project(p);
      if (!(std::abs(pixel.x()) < 1e5 && std::abs(pixel.y()) < 1e5)) continue;
      const int u = static_cast<int>(std::lround(pixel.x()));
      const int v = static_cast<int>(std::lround(pixel.y()));
      if (to.depth_m.contains(u, v) && to.depth_m.at(u, v) > 0) {
        distances.push_back(std::abs(double{to.depth_m.at(u, v)} - p.z()));
      }
    }
  }
  if (distances.size() < 1000) return -1;
  std::nth_element(distances.begin(), distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2),
                   distances.end());
  return distances[distances.size() / 2];
}

struct Warp {
  const char* folder;
  double max_m;  // the data README's worst figure, and a quarter more for other pairs of frames
};
std::ostream& operator<<(std::ostream& out, const Warp& warp) {
  return out << warp.folder;
}

class WarpedRecording : public ::testing::TestWithParam<Warp> {};

TEST_P(WarpedRecording, AgreesWithItselfFromFrameToFrame) {
  const fs::path folder = data_folder() / GetParam().folder;
  if (!fs::exists(folder)) GTEST_SKIP() << "SKIPPED: no " << GetParam().folder << " to read";
  AcquireConfig config = config_for(GetParam().folder);
  config.to = 9;
  const Played played = play(folder, config);
  std::vector<double> medians;
  for (std::size_t i = 1; i < played.frames.size(); ++i) {
    const double median = median_warp_m(played.frames[i - 1], played.frames[i]);
    if (median >= 0) medians.push_back(median);
  }
  ASSERT_FALSE(medians.empty());
  EXPECT_LT(*std::max_element(medians.begin(), medians.end()), GetParam().max_m);
  RecordProperty("worst_median_warp_mm", std::to_string(1e3 * *std::max_element(medians.begin(), medians.end())));
}

INSTANTIATE_TEST_SUITE_P(Shared, WarpedRecording,
                         ::testing::Values(Warp{"rgbd_box_f200", 0.006}, Warp{"rgbd_redwood_lr1_211", 0.016},
                                           Warp{"rgbd_iphone_lidar_corridor_73", 0.039}, Warp{"rgbd_icl_3", 0.006},
                                           Warp{"rgbd_sun3d_studyroom_5", 0.11}));

TEST(RealNormals, CoverTheHoleLatticeOfTheBoxScan) {
  const fs::path folder = data_folder() / "rgbd_box_f200";
  if (!fs::exists(folder)) GTEST_SKIP() << "SKIPPED: no rgbd_box_f200 to read";
  AcquireConfig config;
  config.to = 0;
  Frame frame = play(folder, config).frames.at(0);
  const auto valid = [](const DepthImage& depth_m) {
    return std::count_if(depth_m.pixels().begin(), depth_m.pixels().end(), [](float z) { return z > 0; });
  };
  const auto before = valid(frame.depth_m);
  ASSERT_TRUE(filter_frame(frame, config, {}));
  const auto after = valid(frame.depth_m);
  const auto known = std::count_if(frame.normals.pixels().begin(), frame.normals.pixels().end(),
                                   [](const Eigen::Vector3f& n) { return n.squaredNorm() > 0; });
  EXPECT_GT(static_cast<double>(after), 0.9 * static_cast<double>(before));
  EXPECT_GT(static_cast<double>(known), 0.95 * static_cast<double>(after));
}

}  // namespace
}  // namespace scanknit::test
