// acquire.camera on what is replayed: the lenses, the pose between both cameras, and the error of depth.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "acquire/convert/picture_files.h"
#include "acquire/mcap/append_file.h"
#include "acquire/raw/raw_decode.h"
#include "acquire/record/recording_writer.h"
#include "acquire/record/ros2_recording_writer.h"
#include "acquire/replay/picture_codec.h"
#include "acquire/replay/undistort.h"
#include "acquire/sensor/depth_bias.h"
#include "acquire/sensor/scanner_camera.h"
#include "raw_frames.h"
#include "test_replay_support.h"
#include "tests/support/text.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;
using Reasons = std::vector<std::string>;

constexpr CameraIntrinsics kRoomCamera{64, 48, 60, 61, 31.5, 23.5};
constexpr Distortion kBent = {0.12, -0.08, 0.002, -0.001, 0.01};
constexpr double kUnits = 10000;  ///< a tenth of a millimetre

AcquireConfig with(ScannerCamera camera) {
  AcquireConfig config;
  camera.file = "CAMERA.yaml";
  config.camera = std::make_shared<const ScannerCamera>(std::move(camera));
  return config;
}

/// The error that open_recording() gives.
Error refusal(const fs::path& path, const AcquireConfig& config) {
  const auto source = open_recording(path, config);
  EXPECT_FALSE(source);
  return source ? Error{} : source.error();
}

/// A slanted wall from 0.8 to 2.2 m, with a hole.
DepthImage wall() {
  DepthImage depth_m(kRoomCamera.width, kRoomCamera.height);
  for (int y = 0; y < depth_m.height(); ++y) {
    for (int x = 0; x < depth_m.width(); ++x) {
      const bool is_hole = x < 4 && y < 4;
      depth_m.at(x, y) = is_hole ? 0 : static_cast<float>(1 / (0.45 + 0.01 * x + 0.003 * y));
    }
  }
  return depth_m;
}

DepthBias uneven_bias() {
  DepthBias bias{6, 5, {}, {}};
  for (int i = 0; i < 30; ++i) {
    bias.scale.push_back(0.03 * std::sin(1.3 * i));
    bias.shift_per_m.push_back(0.02 * std::cos(0.7 * i));
  }
  return bias;
}

/// The cubic B-spline with knots at all integers (M. G. Cox and C. de Boor 1972), not 0 for -2 < t < 2.
double basis(double t) {
  const double a = std::abs(t);
  if (a >= 2) return 0;
  return a < 1 ? 2.0 / 3 - a * a + a * a * a / 2 : (2 - a) * (2 - a) * (2 - a) / 6;
}

/// The field of docs/calibration.md: the picture spans the cells in the middle of the numbers.
double field(const std::vector<double>& numbers, const DepthBias& bias, int x, int y) {
  const double across = 1 + (x + 0.5) / kRoomCamera.width * (bias.columns - 3);
  const double down = 1 + (y + 0.5) / kRoomCamera.height * (bias.rows - 3);
  double sum = 0;
  for (int j = 0; j < bias.rows; ++j) {
    for (int i = 0; i < bias.columns; ++i) {
      sum += numbers[static_cast<std::size_t>(j * bias.columns + i)] * basis(across - i) * basis(down - j);
    }
  }
  return sum;
}

/// What a sensor with that error measures: 1 / z = (1 + scale) / z_measured + shift, for z_measured.
DepthImage measured(DepthImage depth_m, const DepthBias& bias) {
  for (int y = 0; y < depth_m.height(); ++y) {
    for (int x = 0; x < depth_m.width(); ++x) {
      float& z = depth_m.at(x, y);
      if (!(z > 0)) continue;
      z = static_cast<float>((1 + field(bias.scale, bias, x, y)) /
                             (1 / static_cast<double>(z) - field(bias.shift_per_m, bias, x, y)));
    }
  }
  return depth_m;
}

ColourImage pattern() {
  ColourImage picture(kRoomCamera.width, kRoomCamera.height);
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      picture.at(x, y) = {static_cast<std::uint8_t>(4 * x), static_cast<std::uint8_t>(5 * y),
                          static_cast<std::uint8_t>(x * y % 256)};
    }
  }
  return picture;
}

/// One frame of the 7-Scenes layout, whose depth is registered to colour. It states another focal length.
class RegisteredRecording : public ::testing::Test {
 protected:
  void write(const DepthImage& depth_m) {
    fs::create_directories(path());
    raw_ = to_raw_depth(depth_m, kUnits);
    ASSERT_TRUE(write_depth_png(raw_, folder_ / seven_scenes_name(0, "depth.png")));
    ASSERT_TRUE(write_colour_png(pattern(), folder_ / seven_scenes_name(0, "color.png")));
    write_text(folder_ / seven_scenes_name(0, "pose.txt"), kIdentity);
    write_text(folder_ / "camera-intrinsics.txt", "70 0 30\n0 70 20\n0 0 1\n");
  }
  [[nodiscard]] Frame frame(AcquireConfig config) const {
    config.depth_scale = kUnits;
    Played played = play(path(), config);
    for (const FrameDropped& drop : played.dropped) ADD_FAILURE() << drop.error.text();
    return played.frames.empty() ? Frame{} : std::move(played.frames.front());
  }
  [[nodiscard]] fs::path path() const { return folder_.path(); }
  [[nodiscard]] DepthImage as_stored() const { return scale_depth(raw_, kUnits); }

  TemporaryFolder folder_;
  Image<std::uint16_t> raw_;
};

double largest_error_m(const DepthImage& found, const DepthImage& truth) {
  double largest = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    largest =
        std::max(largest, std::abs(static_cast<double>(found.pixels()[i]) - static_cast<double>(truth.pixels()[i])));
  }
  return largest;
}

TEST_F(RegisteredRecording, LosesTheErrorOfItsDepth) {
  const DepthBias bias = uneven_bias();
  write(measured(wall(), bias));
  const double stored_m = largest_error_m(frame({}).depth_m, wall());
  EXPECT_GT(stored_m, 0.05) << "the error is there";
  const Frame corrected = frame(with({.depth = CameraModel{kRoomCamera, {}}, .depth_bias = bias}));
  // Half a unit of the file, times the largest slope of the correction for these numbers.
  const double kRounding_m = 0.5 / kUnits * 1.2;
  EXPECT_LT(largest_error_m(corrected.depth_m, wall()), kRounding_m);
  EXPECT_EQ(corrected.depth_m.at(0, 0), 0) << "a hole stays one";
}

TEST_F(RegisteredRecording, LosesTheErrorOfItsStraightenedDepth) {
  write(wall());
  const CameraModel lens{kRoomCamera, kBent};
  const Frame corrected = frame(with({.depth = lens, .depth_bias = uneven_bias()}));
  DepthImage expected = undistort(as_stored(), kRoomCamera, kBent);
  DepthCorrection(uneven_bias(), kRoomCamera.width, kRoomCamera.height).apply(expected);
  EXPECT_EQ(corrected.depth_m, expected);
}

TEST_F(RegisteredRecording, IsStraightenedByTheSameLensOnceInBothPictures) {
  write(wall());
  const CameraModel lens{kRoomCamera, kBent};
  AcquireConfig alone;
  alone.intrinsics = lens;
  const Frame expected = frame(alone);
  for (const AcquireConfig& config : {with({.colour = lens, .depth = lens}), with({.depth = lens})}) {
    const Frame found = frame(config);
    EXPECT_EQ(found.intrinsics, kRoomCamera);
    EXPECT_EQ(found.depth_m, undistort(as_stored(), kRoomCamera, kBent));
    ASSERT_TRUE(found.colour);
    EXPECT_EQ(found.colour->intrinsics, kRoomCamera);
    EXPECT_EQ(found.colour->image, undistort(pattern(), kRoomCamera, kBent));
    EXPECT_TRUE(found.colour->T_colour_depth.isApprox(Pose::Identity()));
    EXPECT_EQ(found.depth_m, expected.depth_m) << "as acquire.intrinsics does";
    EXPECT_EQ(found.colour->image, expected.colour->image);
  }
}

TEST_F(RegisteredRecording, KeepsWhatIsNotStated) {
  write(wall());
  const CameraIntrinsics own{64, 48, 70, 70, 30, 20};
  const Frame found = frame(with({.colour = CameraModel{kRoomCamera, kBent}}));
  EXPECT_EQ(found.intrinsics, own);
  EXPECT_EQ(found.depth_m, as_stored());
  EXPECT_EQ(found.colour.value().intrinsics, kRoomCamera);
  EXPECT_EQ(found.colour->image, undistort(pattern(), kRoomCamera, kBent));
}

TEST_F(RegisteredRecording, OfAnotherSizeIsDropped) {
  write(wall());
  const CameraModel other{{32, 24, 30, 30, 15.5, 11.5}, {}};
  for (const AcquireConfig& config : {with({.depth = other}), with({.colour = other})}) {
    const Played played = play(path(), config);
    EXPECT_TRUE(played.frames.empty());
    EXPECT_EQ(played.reasons(), Reasons{"size_mismatch"});
    EXPECT_TRUE(contains(played.dropped.at(0).error.message, "the picture is 64 x 48, its camera 32 x 24"));
  }
}

TEST_F(RegisteredRecording, WithoutASerialNumberIsTakenForAnyScanners) {
  write(wall());
  EXPECT_EQ(frame(with({.serial = "7", .depth = CameraModel{kRoomCamera, {}}})).intrinsics, kRoomCamera);
}

TEST_F(RegisteredRecording, RefusesWhatIsStatedTwiceOrIsNone) {
  write(wall());
  const CameraModel good{kRoomCamera, {}};
  AcquireConfig both = with({.depth = good});
  both.intrinsics = good;
  EXPECT_TRUE(contains(refusal(path(), both).text(), "CAMERA.yaml: acquire.camera and acquire.intrinsics both"));
  both = with({.colour = good});
  both.intrinsics = good;
  EXPECT_EQ(frame(both).intrinsics, kRoomCamera) << "they state different cameras";

  CameraModel unknown = good;
  unknown.intrinsics.fx = std::numeric_limits<double>::quiet_NaN();
  CameraModel bent = good;
  bent.distortion[4] = std::numeric_limits<double>::infinity();
  const CameraModel unsized{{0, 0, 60, 61, 31.5, 23.5}, {}};
  for (const CameraModel& wrong : {unknown, bent, unsized}) {
    for (const AcquireConfig& config : {with({.colour = wrong}), with({.depth = wrong})}) {
      const Error error = refusal(path(), config);
      EXPECT_EQ(error.code, ErrorCode::kConfig);
      EXPECT_TRUE(contains(error.text(), "acquire.camera: expected finite numbers")) << error.text();
    }
  }
  DepthBias bias = uneven_bias();
  bias.scale.pop_back();
  const Error error = refusal(path(), with({.depth = good, .depth_bias = bias}));
  EXPECT_EQ(error.code, ErrorCode::kConfig);
  EXPECT_TRUE(contains(error.text(), "depth_bias")) << error.text();
}

TEST_F(RegisteredRecording, TakesAMaskFromColourOnlyIfColourIsStatedToSeeTheSame) {
  write(wall());
  ASSERT_TRUE(write_colour_png(ColourImage(64, 48, Rgb8{0, 0, 0}), folder_ / "empty.png"));
  const CameraModel good{kRoomCamera, {}};
  AcquireConfig config = with({.colour = good, .depth = good});
  config.background = (folder_ / "empty.png").string();
  EXPECT_EQ(frame(config).intrinsics, kRoomCamera);
  config = with({.depth = good, .T_colour_depth = Pose(Eigen::Translation3d(0.025, 0, 0))});
  config.background = (folder_ / "empty.png").string();
  const Played played = play(path(), config);
  EXPECT_EQ(played.reasons(), Reasons{"no_intrinsics"});
  EXPECT_TRUE(contains(played.dropped.at(0).error.message, "sees another"));
}

enum class Writer { kOwn, kRos2 };

/// A scanner's own recording, in which colour has a view and a lens of its own.
class ScannerRecording : public ::testing::TestWithParam<Writer> {
 protected:
  void SetUp() override {
    calibration_ = raw_calibration();
    calibration_.depth.distortion = {0.1, -0.05, 0.001, 0.002, 0};
    calibration_.colour.distortion = {-0.2, 0.03, 0, 0, 0};
    auto file = AppendFile::create(path());
    ASSERT_TRUE(file);
    const auto sink = [&](std::span<const std::byte> bytes) { return file->append(bytes); };
    std::unique_ptr<RawFrameWriter> writer;
    if (GetParam() == Writer::kOwn) writer = std::make_unique<RecordingWriter>(sink, calibration_);
    if (GetParam() == Writer::kRos2) {
      writer = std::make_unique<Ros2RecordingWriter>(
          sink, calibration_, std::vector<StreamProfile>{depth_frame(0).profile, colour_frame(0).profile});
    }
    ASSERT_TRUE(writer->begin());
    for (std::uint32_t i = 0; i < 2; ++i) {
      ASSERT_TRUE(writer->write(depth_frame(i)));
      ASSERT_TRUE(writer->write(colour_frame(i)));
    }
    ASSERT_TRUE(writer->finish());
  }
  [[nodiscard]] fs::path path() const { return folder_ / "scan.mcap"; }

  /// Replay gives the frames of a scanner with this calibration.
  void expect_replayed(const AcquireConfig& config, const RawCalibration& calibration) const {
    const Played played = play(path(), config);
    ASSERT_EQ(played.frames.size(), 2u);
    for (std::uint32_t i = 0; i < 2; ++i) {
      const RawFrame colour = colour_frame(i);
      const auto expected = decode_raw_frame(depth_frame(i), &colour, calibration, {});
      ASSERT_TRUE(expected);
      const Frame& found = played.frames[i];
      EXPECT_EQ(found.intrinsics, expected->intrinsics);
      ASSERT_EQ(found.depth_m.size(), expected->depth_m.size());
      for (std::size_t k = 0; k < found.depth_m.size(); ++k) {
        ASSERT_FLOAT_EQ(found.depth_m.pixels()[k], expected->depth_m.pixels()[k]);
      }
      ASSERT_TRUE(found.colour && expected->colour);
      EXPECT_EQ(found.colour->intrinsics, expected->colour->intrinsics);
      EXPECT_EQ(found.colour->image, expected->colour->image);
      EXPECT_TRUE(found.colour->T_colour_depth.isApprox(expected->colour->T_colour_depth, 1e-9));
    }
  }

  TemporaryFolder folder_;
  RawCalibration calibration_;
};

TEST_P(ScannerRecording, IsReadWithEachPartThatIsStated) {
  const CameraModel depth{{64, 48, 58, 59, 30, 25}, kBent};
  const CameraModel colour{{32, 24, 31, 29, 14.5, 12.5}, {0.05, 0.02, 0, 0, 0}};
  const Pose T_colour_depth = Pose(Eigen::Translation3d(-0.02, 0.01, 0.003));
  expect_replayed({}, calibration_);
  for (int parts = 1; parts < 8; ++parts) {
    SCOPED_TRACE(parts);
    ScannerCamera camera;
    RawCalibration stated = calibration_;
    if ((parts & 1) != 0) stated.depth = *(camera.depth = depth);
    if ((parts & 2) != 0) stated.colour = *(camera.colour = colour);
    if ((parts & 4) != 0) stated.T_colour_depth = *(camera.T_colour_depth = T_colour_depth);
    expect_replayed(with(camera), stated);
  }
}

TEST_P(ScannerRecording, LosesTheErrorOfItsDepth) {
  const CameraModel lens{{64, 48, 60, 61, 31.5, 23.5}, kBent};
  const Played plain = play(path(), with({.depth = lens}));
  const Played corrected = play(path(), with({.depth = lens, .depth_bias = uneven_bias()}));
  ASSERT_EQ(corrected.frames.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    DepthImage expected = plain.frames[i].depth_m;
    DepthCorrection(uneven_bias(), 64, 48).apply(expected);
    EXPECT_EQ(corrected.frames[i].depth_m, expected);
  }
}

TEST_P(ScannerRecording, OfAnotherSizeIsDropped) {
  const CameraModel other{{128, 96, 60, 60, 63.5, 47.5}, {}};
  for (const AcquireConfig& config : {with({.depth = other}), with({.colour = other})}) {
    EXPECT_EQ(play(path(), config).reasons(), (Reasons{"size_mismatch", "size_mismatch"}));
  }
}

INSTANTIATE_TEST_SUITE_P(Files, ScannerRecording, ::testing::Values(Writer::kOwn, Writer::kRos2),
                         [](const auto& writer) { return writer.param == Writer::kOwn ? "own" : "ros2"; });

TEST(ScannersSerialNumber, ThatIsAnotherIsRefused) {
  const TemporaryFolder folder;
  const fs::path path = folder / "scan.mcap";
  {
    auto file = AppendFile::create(path);
    ASSERT_TRUE(file);
    RecordingWriter writer([&](std::span<const std::byte> bytes) { return file->append(bytes); }, raw_calibration());
    ASSERT_TRUE(writer.begin());
    ASSERT_TRUE(writer.write(depth_frame(0)));
    ASSERT_TRUE(writer.finish());
  }
  const CameraModel depth = raw_calibration().depth;
  const Error error = refusal(path, with({.serial = "0002", .depth = depth}));
  EXPECT_EQ(error.code, ErrorCode::kConfig);
  EXPECT_EQ(error.text(),
            "CAMERA.yaml: acquire.camera: this is the calibration of the scanner with serial number 0002, not of that "
            "with 0001; give that scanner's own file");
  EXPECT_EQ(play(path, with({.serial = "0001", .depth = depth})).frames.size(), 1u);
  EXPECT_EQ(play(path, with({.depth = depth})).frames.size(), 1u);
}

/// What a scanner streams.
const std::array kStreams = {depth_frame(0).profile, colour_frame(0).profile};

TEST(ScannersCalibration, IsOverriddenByWhatIsStated) {
  ScannerCamera camera;
  camera.depth = CameraModel{{64, 48, 58, 59, 30, 25}, kBent};
  RawCalibration calibration = raw_calibration();
  ASSERT_TRUE(override_calibration(camera, kStreams, calibration));
  EXPECT_EQ(calibration.depth, *camera.depth);
  EXPECT_EQ(calibration.colour, raw_calibration().colour);
  EXPECT_EQ(calibration.T_colour_depth.matrix(), raw_calibration().T_colour_depth.matrix());

  camera.colour = CameraModel{{32, 24, 31, 29, 14.5, 12.5}, {}};
  camera.T_colour_depth = Pose(Eigen::Translation3d(-0.02, 0.01, 0.003));
  ASSERT_TRUE(override_calibration(camera, kStreams, calibration));
  EXPECT_EQ(calibration.colour, *camera.colour);
  EXPECT_EQ(calibration.T_colour_depth.matrix(), camera.T_colour_depth->matrix());
}

TEST(ScannersCalibration, IsNotOverriddenByAnotherSizesOrScanners) {
  RawCalibration calibration = raw_calibration();
  ScannerCamera camera{.file = "CAMERA.yaml"};
  camera.colour = CameraModel{{64, 48, 31, 29, 14.5, 12.5}, {}};
  auto done = override_calibration(camera, kStreams, calibration);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, ErrorCode::kConfig);
  EXPECT_TRUE(contains(done.error().text(),
                       "its colour camera is for pictures of 64 x 48, but the scanner sends "
                       "32 x 24"))
      << done.error().text();
  camera.serial = "0002";
  done = override_calibration(camera, kStreams, calibration);
  ASSERT_FALSE(done);
  EXPECT_TRUE(contains(done.error().text(), "serial number 0002")) << done.error().text();
}

}  // namespace
}  // namespace scanknit::test
