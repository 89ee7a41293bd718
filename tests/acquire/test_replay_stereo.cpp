// Recordings of stereo pairs: their files, and what becomes of a wall that two cameras see.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <string>

#include "acquire/convert/picture_files.h"
#include "acquire/stereo/keyed_numbers.h"
#include "tests/acquire/test_replay_support.h"
#include "tests/support/text.h"

namespace scanknit {
namespace {

using test::contains;
using test::open_error;
using test::play;
using test::Played;
using test::TemporaryFolder;
using test::write_text;

namespace fs = std::filesystem;

KeyedNumbers keyed_of(const std::string& text) {
  auto keyed = parse_keyed_numbers(text);
  EXPECT_TRUE(keyed) << keyed.error().message;
  return keyed ? *std::move(keyed) : KeyedNumbers{};
}

TEST(KeyedNumbers, ReadsMapsAndListsInBothStyles) {
  const KeyedNumbers keyed = keyed_of(
      "# a rig\nleft: {fx: 500, 'cy': 2.5, distortion: [1, -2e-1]}\nright:\n  fx: 501  # measured\n  lens:\n    k: "
      "[1,\n"
      "      2]\n    name: \"wide\"\nrows:\n  - [1, 2]\n  - [3, 4]\nbaseline: 0.06\n");
  EXPECT_EQ(keyed.number("left.fx"), 500);
  EXPECT_EQ(keyed.number("left.cy"), 2.5);
  ASSERT_NE(keyed.find("left.distortion", 2), nullptr);
  EXPECT_EQ(keyed.find("left.distortion")->back(), -0.2);
  EXPECT_EQ(keyed.number("right.fx"), 501);
  ASSERT_NE(keyed.find("right.lens.k", 2), nullptr);
  EXPECT_EQ(keyed.texts.at("right.lens.name"), "wide");
  ASSERT_NE(keyed.find("rows", 4), nullptr);
  EXPECT_EQ(keyed.number("baseline"), 0.06);
}

constexpr const char* kOpenCvYaml =
    "%YAML:1.0\n---\nM1: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 200., 0., 79.5, 0.,\n       "
    "200., "
    "59.5, 0., 0., 1. ]\nD1: !!opencv-matrix\n   rows: 1\n   cols: 5\n   dt: d\n   data: [ 0., 0., 0., 0., 0. ]\nM2: "
    "!!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 200., 0., 79.5, 0., 200., 59.5, 0., 0., 1. ]\nR: "
    "!!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 1., 0., 0., 0., 1., 0., 0., 0., 1. ]\nT: "
    "!!opencv-matrix\n   rows: 3\n   cols: 1\n   dt: d\n   data: [ -0.1, 1e-9, 0. ]\n";

TEST(KeyedNumbers, ReadsOpenCvsMatrices) {
  const KeyedNumbers yaml = keyed_of(kOpenCvYaml);
  ASSERT_NE(yaml.find("M1.data", 9), nullptr);
  EXPECT_EQ((*yaml.find("M1.data"))[4], 200);
  const KeyedNumbers xml = keyed_of(
      "<?xml version=\"1.0\"?>\n<opencv_storage>\n<T type_id=\"opencv-matrix\">\n  <rows>3</rows>\n  <data>\n    -0.1 "
      "0. 2.</data></T>\n</opencv_storage>\n");
  ASSERT_NE(xml.find("T.data", 3), nullptr);
  EXPECT_EQ((*xml.find("T.data"))[0], -0.1);
}

TEST(KeyedNumbers, RefusesWhatNoCameraFileHas) {
  EXPECT_FALSE(parse_keyed_numbers("left: [1, 2"));
  EXPECT_FALSE(parse_keyed_numbers("left: {fx: [1, 2"));
  std::string deep_yaml, deep_xml;
  for (std::size_t i = 0; i < 20; ++i) {
    deep_yaml += std::string(i, ' ') + "a:\n";
    deep_xml += "<a>";
  }
  EXPECT_FALSE(parse_keyed_numbers(deep_yaml));
  EXPECT_FALSE(parse_keyed_numbers(deep_xml));
  EXPECT_FALSE(parse_keyed_numbers(std::string(200, 'k') + ": 1\n"));
  EXPECT_FALSE(parse_keyed_numbers(std::string(2u << 20, ' ')));
}

TEST(KeyedNumbers, SurviveACutAtEveryByte) {
  const std::string yaml = kOpenCvYaml;
  const std::string more = "left: {fx: 500, cy: [1, 2]}\n- 3\n  - [1]\n]: }\n<a><b/></c>";
  for (const std::string& text : {yaml, more, "<?xml?>" + more}) {
    for (std::size_t end = 0; end <= text.size(); ++end) {
      const auto keyed = parse_keyed_numbers(std::string_view(text).substr(0, end));
      if (keyed) {
        EXPECT_LE(keyed->numbers.size(), text.size());
      }
    }
  }
}

/// Smooth random spots of about four pixels.
double spots(double u, double v) {
  const auto lattice = [](std::int64_t x, std::int64_t y) {
    std::uint64_t h = static_cast<std::uint64_t>(x) * 0x9E3779B97F4A7C15u + static_cast<std::uint64_t>(y);
    h = (h ^ (h >> 31)) * 0xBF58476D1CE4E5B9u;
    return static_cast<double>((h ^ (h >> 29)) % 256);
  };
  const double x = std::floor(u / 4), y = std::floor(v / 4);
  const double a = u / 4 - x, b = v / 4 - y;
  const auto i = static_cast<std::int64_t>(x);
  const auto j = static_cast<std::int64_t>(y);
  return (1 - b) * ((1 - a) * lattice(i, j) + a * lattice(i + 1, j)) +
         b * ((1 - a) * lattice(i, j + 1) + a * lattice(i + 1, j + 1));
}

struct Wall {
  int width = 160, height = 120;
  double disparity_px = 10.3;  ///< with f = 200 pixels and a baseline of 0.1 m: 1.94 m
  double rows_px = 0;
  bool is_bare = false;
};
constexpr double kFocalTimesBaseline = 20;

ColourImage picture_of_wall(const Wall& wall, bool is_right) {
  ColourImage picture(wall.width, wall.height);
  for (int y = 0; y < wall.height; ++y) {
    for (int x = 0; x < wall.width; ++x) {
      const double value = wall.is_bare ? 128 : is_right ? spots(x + wall.disparity_px, y - wall.rows_px) : spots(x, y);
      const auto grey = static_cast<std::uint8_t>(std::lround(value));
      picture.at(x, y) = {grey, grey, grey};
    }
  }
  return picture;
}

void write_pair(const Wall& wall, const fs::path& left, const fs::path& right) {
  fs::create_directories(left.parent_path());
  fs::create_directories(right.parent_path());
  ASSERT_TRUE(write_colour_png(picture_of_wall(wall, false), left));
  ASSERT_TRUE(write_colour_png(picture_of_wall(wall, true), right));
}

constexpr const char* kOwnRig =
    "left: {width: 160, height: 120, fx: 200, fy: 200, cx: 79.5, cy: 59.5}\nbaseline: 0.1\n";

class StereoRecording : public ::testing::Test {
 protected:
  void write(const Wall& wall, const std::string& name = "000000.png") const {
    write_pair(wall, folder_ / "left" / name, folder_ / "right" / name);
  }
  void write_rig(const std::string& text = kOwnRig, const std::string& name = "stereo.yaml") const {
    write_text(folder_ / name, text);
  }
  [[nodiscard]] static AcquireConfig stereo() {
    AcquireConfig config;
    config.geometry = Geometry::kStereo;
    config.poses = PoseMode::kStill;
    return config;
  }
  [[nodiscard]] Played played(const AcquireConfig& config = stereo()) const { return play(folder_.path(), config); }

  /// The median depth, and most pixels have one.
  static void expect_wall(const Frame& frame, double disparity_px) {
    std::vector<float> depths;
    for (const float z : frame.depth_m.pixels()) {
      if (z > 0) depths.push_back(z);
    }
    ASSERT_GT(depths.size(), 8 * frame.depth_m.size() / 10);
    std::nth_element(depths.begin(), depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2), depths.end());
    const double found_px = kFocalTimesBaseline / static_cast<double>(depths[depths.size() / 2]);
    EXPECT_NEAR(found_px, disparity_px, 0.05);
  }
  void expect_one_wall(const AcquireConfig& config = stereo()) const {
    const Played all = played(config);
    ASSERT_EQ(all.frames.size(), 1u) << (all.dropped.empty() ? "" : all.dropped[0].error.text());
    expect_wall(all.frames[0], Wall{}.disparity_px);
  }

  TemporaryFolder folder_;
};

TEST_F(StereoRecording, FindsHowFarAWallIs) {
  write({});
  write_rig();
  const Played all = played();
  ASSERT_EQ(all.frames.size(), 1u);
  expect_wall(all.frames[0], Wall{}.disparity_px);
  ASSERT_TRUE(all.frames[0].colour);
  EXPECT_EQ(all.frames[0].colour->image, picture_of_wall({}, false));
  EXPECT_EQ(all.frames[0].intrinsics.fx, 200);
}

TEST_F(StereoRecording, GivesTheSameBitsForAnyNumberOfThreads) {
  write({});
  write_rig();
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const Played one = played();
  cv::setNumThreads(2);
  const Played many = played();
  cv::setNumThreads(threads);
  ASSERT_EQ(one.frames.size(), 1u);
  ASSERT_EQ(many.frames.size(), 1u);
  EXPECT_EQ(one.frames[0].depth_m, many.frames[0].depth_m);
}

TEST_F(StereoRecording, KnowsItsNoise) {
  write({});
  write_rig();
  const auto source = open_recording(folder_.path(), stereo());
  ASSERT_TRUE(source) << source.error().text();
  const RecordingInfo& info = (*source)->info();
  EXPECT_EQ(info.format, "stereo");
  EXPECT_TRUE(info.warnings.empty());
  ASSERT_TRUE(info.sensor && info.sensor->own_noise);
  EXPECT_NEAR(info.sensor->own_noise->sigma_m(2), 0.2 * 4 / kFocalTimesBaseline, 0.001);
}

TEST_F(StereoRecording, ReadsOpenCvsCalibration) {
  write({});
  write_rig(kOpenCvYaml, "stereo.yml");
  expect_one_wall();
}

TEST_F(StereoRecording, ReadsKalibrsCalibration) {
  write({});
  write_rig(
      "cam0:\n  distortion_model: radtan\n  distortion_coeffs: [0, 0, 0, 0]\n  intrinsics: [200, 200, 79.5, 59.5]\n  "
      "resolution: [160, 120]\ncam1:\n  T_cn_cnm1:\n  - [1.0, 0.0, 0.0, -0.1]\n  - [0.0, 1.0, 0.0, 0.0]\n  - [0.0, "
      "0.0, "
      "1.0, 0.0]\n  - [0.0, 0.0, 0.0, 1.0]\n  intrinsics: [200, 200, 79.5, 59.5]\n  resolution: [160, 120]\n",
      "camchain.yaml");
  expect_one_wall();
}

TEST_F(StereoRecording, ReadsKittisLayout) {
  write_pair({}, folder_ / "image_0" / "000000.png", folder_ / "image_1" / "000000.png");
  write_pair({}, folder_ / "image_0" / "000001.png", folder_ / "image_1" / "000001.png");
  write_rig("P0: 200 0 79.5 0 0 200 59.5 0 0 0 1 0\nP1: 200 0 79.5 -20 0 200 59.5 0 0 0 1 0\n", "calib.txt");
  write_text(folder_ / "times.txt", "0.0\n0.1\n");
  const Played all = played();
  ASSERT_EQ(all.frames.size(), 2u);
  expect_wall(all.frames[1], Wall{}.disparity_px);
  EXPECT_EQ(all.frames[1].timestamp_ns, 100'000'000);
}

TEST_F(StereoRecording, ReadsEurocsLayout) {
  const std::string name = "1403636579763555584.png";
  const fs::path mav = folder_ / "mav0";
  write_pair({}, mav / "cam0/data" / name, mav / "cam1/data" / name);
  const auto sensor = [](const char* x) {
    return std::string("sensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: [1.0, 0.0, 0.0, ") + x +
           ",\n         0.0, 1.0, 0.0, 0.0,\n         0.0, 0.0, 1.0, 0.0,\n         0.0, 0.0, 0.0, 1.0]\nresolution: "
           "[160, 120]\nintrinsics: [200, 200, 79.5, 59.5] #fu, fv, cu, cv\ndistortion_model: radial-tangential\n"
           "distortion_coefficients: [0.0, 0.0, 0.0, 0.0]\n";
  };
  write_text(mav / "cam0/sensor.yaml", sensor("1.0"));
  write_text(mav / "cam1/sensor.yaml", sensor("1.1"));
  const Played all = played();
  ASSERT_EQ(all.frames.size(), 1u);
  expect_wall(all.frames[0], Wall{}.disparity_px);
  EXPECT_EQ(all.frames[0].timestamp_ns, 1403636579763555584);
}

TEST_F(StereoRecording, TakesPosesByFrameNumber) {
  write({}, "000004.png");
  write({}, "000007.png");
  write_rig();
  write_text(folder_ / "trajectory.txt", "4 0 0 0 0 0 0 1\n7 1 2 3 0 0 0 1\n");
  AcquireConfig config = stereo();
  config.poses = PoseMode::kAuto;
  const Played all = played(config);
  ASSERT_EQ(all.frames.size(), 2u);
  EXPECT_EQ(all.frames[1].sequence, 7u);
  ASSERT_TRUE(all.frames[1].T_world_camera);
  EXPECT_EQ(all.frames[1].T_world_camera->translation(), Eigen::Vector3d(1, 2, 3));
}

TEST_F(StereoRecording, DropsAPairWithoutItsRightPicture) {
  write({}, "0.png");
  write({}, "1.png");
  write_rig();
  fs::remove(folder_ / "right" / "1.png");
  const Played all = played();
  EXPECT_EQ(all.frames.size(), 1u);
  EXPECT_EQ(all.reasons(), std::vector<std::string>{"missing_file"});
}

TEST_F(StereoRecording, DropsPicturesOfDifferentSizes) {
  write({}, "0.png");
  write({}, "1.png");
  write({.width = 80}, "2.png");
  ASSERT_TRUE(write_colour_png(picture_of_wall({.width = 100}, true), folder_ / "right" / "1.png"));
  write_rig();
  const Played all = played();
  EXPECT_EQ(all.frames.size(), 1u);
  EXPECT_EQ(all.reasons(), (std::vector<std::string>{"size_mismatch", "size_mismatch"}));
}

TEST_F(StereoRecording, DropsAPairWithoutTexture) {
  write({}, "0.png");
  write({.is_bare = true}, "1.png");
  write_rig();
  const Played all = played();
  EXPECT_EQ(all.frames.size(), 1u);
  ASSERT_EQ(all.reasons(), std::vector<std::string>{"no_depth"});
  EXPECT_TRUE(contains(all.dropped[0].error.message, "too little texture")) << all.dropped[0].error.message;
}

TEST_F(StereoRecording, TakesPicturesOfAnySize) {
  for (const int side : {1, 2, 7, 8, 17}) {
    write({.width = side, .height = side});
    write_rig("left: {fx: 200, fy: 200, cx: 0, cy: 0}\nbaseline: 0.1\n");
    const Played all = played();
    EXPECT_EQ(all.frames.size() + all.dropped.size(), 1u);
    EXPECT_TRUE(all.errors.empty());
  }
}

TEST_F(StereoRecording, AllowsThatTheMiddleOfTheRightPictureIsElsewhere) {
  for (const double shift_px : {-6.5, 6.5}) {
    write({.disparity_px = Wall{}.disparity_px + shift_px});
    write_rig(std::string("left: {fx: 200, fy: 200, cx: 79.5, cy: 59.5}\nright: {fx: 200, fy: 200, cx: ") +
              std::to_string(79.5 - shift_px) + ", cy: 59.5}\nbaseline: 0.1\n");
    expect_one_wall();
  }
}

/// Semi-global matching would go on with the wall's depth.
TEST_F(StereoRecording, GivesNoDepthToABareBackgroundWithNoise) {
  constexpr int kEdge = 80;
  for (const bool is_right : {false, true}) {
    ColourImage picture = picture_of_wall({.disparity_px = 10}, is_right);
    for (int y = 0; y < picture.height(); ++y) {
      for (int x = kEdge - (is_right ? 10 : 0); x < picture.width(); ++x) {
        const double noise = spots(1e4 + 4 * x, 4 * y + (is_right ? 1e5 : 0)) / 64;
        const auto grey = static_cast<std::uint8_t>(20 + std::lround(noise));
        picture.at(x, y) = {grey, grey, grey};
      }
    }
    const fs::path folder = folder_ / (is_right ? "right" : "left");
    fs::create_directories(folder);
    ASSERT_TRUE(write_colour_png(picture, folder / "0.png"));
  }
  write_rig();
  const Played all = played();
  ASSERT_EQ(all.frames.size(), 1u);
  const DepthImage& depth_m = all.frames[0].depth_m;
  int on_wall = 0, beside = 0;
  for (int y = 0; y < depth_m.height(); ++y) {
    for (int x = 0; x < depth_m.width(); ++x) {
      if (depth_m.at(x, y) > 0) ++(x < kEdge ? on_wall : beside);
    }
  }
  EXPECT_GT(on_wall, 60 * 100);
  EXPECT_LT(beside, 200) << "of 9600 pixels";
}

TEST_F(StereoRecording, SaysThatLeftAndRightAreExchanged) {
  write({.disparity_px = -10});
  write_rig();
  EXPECT_TRUE(contains(open_error(folder_.path(), stereo()), "left and right are exchanged"));
}

TEST_F(StereoRecording, WarnsOfPicturesThatAreNotRectified) {
  for (const double rows_px : {2.0, -2.0}) {
    write({.rows_px = rows_px});
    write_rig();
    const auto source = open_recording(folder_.path(), stereo());
    ASSERT_TRUE(source) << source.error().text();
    ASSERT_EQ((*source)->info().warnings.size(), 1u);
    const std::string& warning = (*source)->info().warnings[0];
    EXPECT_TRUE(contains(warning, rows_px > 0 ? "2.0 pixels lower" : "2.0 pixels higher")) << warning;
  }
}

TEST_F(StereoRecording, SaysWhatIsWrongWithARig) {
  write({});
  EXPECT_TRUE(contains(open_error(folder_.path(), stereo()), "expected stereo.yaml"));
  const std::string left = "left: {fx: 200, fy: 200, cx: 79.5, cy: 59.5}\n";
  const std::pair<std::string, const char*> cases[] = {
      {left, "expected baseline"},
      {left + "baseline: 0\n", "the baseline is 0"},
      {left + "baseline: -0.1\n", "the right camera is on the left"},
      {left + "baseline: 60\n", "unit millimetres"},
      {left + "T_right_left: [1,0,0,0, 0,1,0,-0.1, 0,0,1,0, 0,0,0,1]\n", "not side by side"},
      {left + "T_right_left: [1,0,0,0, 0,1,0,-0.1]\n", "4 x 4"},
      {left + "T_right_left: [2,0,0,-0.1, 0,1,0,0, 0,0,1,0, 0,0,0,1]\n", "T_right_left"},
      {"left: {fx: 200, fy: 200, cx: 79.5}\nbaseline: 0.1\n", "left.cy is missing"},
      {"left: {fx: 0, fy: 200, cx: 79.5, cy: 1}\nbaseline: 0.1\n", "above 0"},
      {left + "right: {fx: 200, fy: 200, cx: 500, cy: 59.5}\nbaseline: 0.1\n", "cx differ"},
      {"left: {fx: 200, fy: 200, cx: 1e300, cy: 1}\nbaseline: 0.1\n", "expected fx, fy, cx, cy"},
      {"M1: 3\n", "M1 is missing"},
      {"left: {fx: [1", "do not close"},
  };
  for (const auto& [text, message] : cases) {
    write_rig(text);
    const std::string error = open_error(folder_.path(), stereo());
    EXPECT_TRUE(contains(error, message)) << error;
    EXPECT_TRUE(contains(error, "stereo.yaml")) << error;
  }
}

TEST_F(StereoRecording, RefusesACameraForDepth) {
  write({});
  write_rig();
  AcquireConfig config = stereo();
  config.intrinsics = CameraModel{{160, 120, 200, 200, 79.5, 59.5}, {}};
  EXPECT_TRUE(contains(open_error(folder_.path(), config), "acquire.intrinsics"));
  for (const bool is_depth : {true, false}) {
    ScannerCamera camera{.file = "CAMERA.yaml"};
    (is_depth ? camera.depth : camera.colour) = config.intrinsics;
    AcquireConfig with_camera = stereo();
    with_camera.camera = std::make_shared<const ScannerCamera>(camera);
    EXPECT_TRUE(contains(open_error(folder_.path(), with_camera), "CAMERA.yaml: acquire.camera: not for stereo pairs"));
  }
}

TEST_F(StereoRecording, IsPointedOutWhereDepthIsLookedFor) {
  write({});
  write_rig();
  EXPECT_TRUE(contains(open_error(folder_.path(), {}), "acquire.geometry=stereo"));
  EXPECT_TRUE(contains(open_error(folder_ / "left", stereo()), "left/ and right/"));
}

}  // namespace
}  // namespace scanknit
