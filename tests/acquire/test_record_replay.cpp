// Our recordings played back: a recording like the others.
#include <gtest/gtest.h>

#include "acquire/mcap/append_file.h"
#include "acquire/raw/raw_decode.h"
#include "acquire/record/recording_writer.h"
#include "raw_frames.h"
#include "test_replay_support.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;

// Chunks of `per_chunk` depth and colour pictures each.
void write_recording(const fs::path& path, std::uint32_t count, std::uint32_t per_chunk = 4, bool with_pose = false,
                     RawCalibration calibration = raw_calibration()) {
  auto file = AppendFile::create(path);
  ASSERT_TRUE(file);
  RecordingWriter writer([&](std::span<const std::byte> bytes) { return file->append(bytes); }, calibration);
  ASSERT_TRUE(writer.begin());
  for (std::uint32_t i = 0; i < count; ++i) {
    ASSERT_TRUE(writer.write(depth_frame(i)));
    ASSERT_TRUE(writer.write(colour_frame(i)));
    if (with_pose) writer.write_pose(depth_frame(i), Pose(Eigen::Translation3d(0.1 * i, 0, 0)));
    if (i % per_chunk == per_chunk - 1) {
      ASSERT_TRUE(writer.flush());
    }
  }
  ASSERT_TRUE(writer.finish());
}

class Replay : public ::testing::Test {
 protected:
  TemporaryFolder folder_;
  fs::path path_ = folder_ / "scan.mcap";
};

void expect_same(const Frame& a, const Frame& b) {
  EXPECT_EQ(a.sequence, b.sequence);
  EXPECT_EQ(a.timestamp_ns, b.timestamp_ns);
  EXPECT_EQ(a.depth_m, b.depth_m);
  EXPECT_EQ(a.intrinsics, b.intrinsics);
  ASSERT_EQ(a.colour.has_value(), b.colour.has_value());
  if (!a.colour) return;
  EXPECT_EQ(a.colour->image, b.colour->image);
  EXPECT_EQ(a.colour->intrinsics, b.colour->intrinsics);
  EXPECT_EQ(a.colour->T_colour_depth.matrix(), b.colour->T_colour_depth.matrix());
}

TEST_F(Replay, GivesTheFramesThatLiveCaptureGave) {
  RawCalibration calibration = raw_calibration();
  calibration.depth.distortion = {0.1, -0.05, 0.001, 0.002, 0};
  calibration.colour.distortion = {-0.2, 0.03, 0, 0, 0};
  calibration.depth_unit_m = 0.00025;
  write_recording(path_, 9, 4, false, calibration);
  const Played played = play(path_);
  ASSERT_EQ(played.frames.size(), 9u);
  for (std::uint32_t i = 0; i < 9; ++i) {
    const RawFrame colour = colour_frame(i);
    expect_same(played.frames[i], *decode_raw_frame(depth_frame(i), &colour, calibration, {}));
  }
}

TEST_F(Replay, GivesTheSameFramesEachTime) {
  write_recording(path_, 9);
  const Played first = play(path_);
  const Played second = play(path_);
  ASSERT_EQ(first.frames.size(), 9u);
  ASSERT_EQ(second.frames.size(), 9u);
  for (std::size_t i = 0; i < 9; ++i) expect_same(first.frames[i], second.frames[i]);
}

TEST_F(Replay, OfAPartGivesTheSameFramesAsTheWhole) {
  write_recording(path_, 12);
  const Played whole = play(path_);
  AcquireConfig config;
  config.from = 3;
  config.to = 9;
  config.every = 3;
  const Played part = play(path_, config);
  ASSERT_EQ(part.frames.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) expect_same(part.frames[i], whole.frames[3 + 3 * i]);
}

TEST_F(Replay, KnowsTheColourCameraWhereTheFirstPictureHasNoColour) {
  {
    auto file = AppendFile::create(path_);
    ASSERT_TRUE(file);
    RecordingWriter writer([&](std::span<const std::byte> bytes) { return file->append(bytes); }, raw_calibration());
    ASSERT_TRUE(writer.begin());
    for (std::uint32_t i = 0; i < 12; ++i) {
      ASSERT_TRUE(writer.write(depth_frame(i)));
      if (i >= 6) {
        ASSERT_TRUE(writer.write(colour_frame(i)));
      }
    }
    ASSERT_TRUE(writer.finish());
  }
  const auto source = open_recording(path_, {});
  ASSERT_TRUE(source) << source.error().text();
  EXPECT_TRUE((*source)->info().has_colour);
  EXPECT_EQ((*source)->info().intrinsics, raw_calibration().depth.intrinsics);
  EXPECT_EQ((*source)->info().colour_intrinsics, raw_calibration().colour.intrinsics);
}

TEST_F(Replay, SaysWhatItIs) {
  write_recording(path_, 10);
  const auto source = open_recording(path_, {});
  ASSERT_TRUE(source) << source.error().text();
  const RecordingInfo& info = (*source)->info();
  EXPECT_EQ(info.format, "mcap");
  EXPECT_EQ(info.frames, 10u);
  EXPECT_EQ(info.frames_with_pose, 0u);
  EXPECT_EQ(info.poses, PoseMode::kTrack);
  EXPECT_TRUE(info.has_colour);
  EXPECT_EQ(info.intrinsics, raw_calibration().depth.intrinsics);
  EXPECT_NEAR(*info.duration_s, 9 * 1e-9 * static_cast<double>(kPeriod_ns), 1e-6);
  EXPECT_TRUE(info.warnings.empty());
}

TEST_F(Replay, HasThePosesThatWereRecorded) {
  write_recording(path_, 5, 2, true);
  const Played played = play(path_);
  ASSERT_EQ(played.frames.size(), 5u);
  EXPECT_EQ(played.frames[3].T_world_camera->translation().x(), 0.1 * 3);
}

TEST_F(Replay, OfATornFileGivesEveryWholeChunkAndWarns) {
  write_recording(path_, 12);
  auto bytes = bytes_of(path_);
  for (const double part : {0.4, 0.7}) {
    const fs::path torn = folder_ / "torn.mcap";
    write_bytes(torn,
                {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(part * static_cast<double>(bytes.size()))});
    auto source = open_recording(torn, {});
    ASSERT_TRUE(source) << source.error().text();
    EXPECT_EQ((*source)->info().warnings.size(), 1u);
    const Played played = play(**source);
    EXPECT_EQ(played.frames.size() % 4, 0u);
    EXPECT_GT(played.frames.size(), 0u);
    EXPECT_TRUE(played.dropped.empty());
  }
}

TEST_F(Replay, DropsTheFramesOfADamagedChunk) {
  write_recording(path_, 12);
  auto bytes = bytes_of(path_);
  bytes[bytes.size() / 2] ^= std::byte{1};
  write_bytes(path_, bytes);
  const Played played = play(path_);
  EXPECT_EQ(played.frames.size(), 8u);
  EXPECT_EQ(played.reasons(), (std::vector<std::string>(4, "unreadable")));
}

TEST_F(Replay, TakesTheCameraAndUnitThatAreStated) {
  write_recording(path_, 2);
  AcquireConfig config;
  config.intrinsics = CameraModel{{0, 0, 50, 51, 30, 20}, {0.1, 0, 0, 0, 0}};
  config.depth_scale = 2000;
  RawCalibration stated = raw_calibration();
  stated.depth = *config.intrinsics;
  stated.depth_unit_m = 1.0 / 2000;
  const RawFrame colour = colour_frame(0);
  expect_same(play(path_, config).frames.at(0), *decode_raw_frame(depth_frame(0), &colour, stated, {}));
}

TEST_F(Replay, WithoutACameraSaysHowToStateIt) {
  RawCalibration none = raw_calibration();
  none.depth = {};
  write_recording(path_, 2, 4, false, none);
  EXPECT_NE(open_error(path_).find("acquire.intrinsics"), std::string::npos);
  AcquireConfig config;
  config.intrinsics = CameraModel{{0, 0, 50, 51, 30, 20}, {}};
  EXPECT_EQ(play(path_, config).frames.size(), 2u);
}

TEST_F(Replay, OfAForeignMcapFileSaysThatItIsNone) {
  write_bytes(path_, std::vector<std::byte>(kMcapMagic.begin(), kMcapMagic.end()));
  EXPECT_NE(open_error(path_).find("not a recording of ours"), std::string::npos);
}

TEST_F(Replay, PairsByTheCamerasClock) {
  auto file = AppendFile::create(path_);
  RecordingWriter writer([&](std::span<const std::byte> bytes) { return file->append(bytes); }, raw_calibration());
  ASSERT_TRUE(writer.begin());
  for (std::uint32_t i = 0; i < 6; ++i) {
    ASSERT_TRUE(writer.write(depth_frame(i)));
    if (i != 2) {
      ASSERT_TRUE(writer.write(colour_frame(i, i % 2 == 0 ? 10'000'000 : -10'000'000)));
    }
  }
  ASSERT_TRUE(writer.finish());
  const Played played = play(path_);
  ASSERT_EQ(played.frames.size(), 6u);
  EXPECT_FALSE(played.frames[2].colour) << "its own is missing, and both others are farther than half a period";
  for (const std::size_t i : {0u, 1u, 3u, 4u, 5u}) {
    ASSERT_TRUE(played.frames[i].colour);
    const auto number = static_cast<std::uint32_t>(i);
    EXPECT_EQ(played.frames[i].colour->image, *decode_raw_colour(colour_frame(number), {}));
  }
}

}  // namespace
}  // namespace scanknit::test
