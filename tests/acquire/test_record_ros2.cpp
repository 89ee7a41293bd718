// A scanner's pictures as a bag of ROS 2: what `record --ros2` writes is read as what `record` writes.
#include <gtest/gtest.h>

#include <thread>

#include "acquire/record/recorder.h"
#include "acquire/record/recording_writer.h"
#include "acquire/record/ros2_recording_writer.h"
#include "raw_frames.h"
#include "test_replay_support.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t kRecordedPairs = 7;

/// Colour of this number in a format, even numbers of bytes that count upwards.
RawFrame colour_as(PixelFormat format, std::uint32_t number) {
  RawFrame frame = colour_frame(number);
  frame.profile.format = format;
  if (format == PixelFormat::kYuyv || format == PixelFormat::kUyvy) {
    auto bytes = *frame.bytes;
    bytes.resize(32 * 24 * 2);
    frame.bytes = share(std::move(bytes));
  }
  return frame;
}

std::vector<StreamProfile> streams_with(PixelFormat format) {
  return {depth_frame(0).profile, colour_as(format, 0).profile};
}

void write_with(RawFrameWriter& writer, PixelFormat format) {
  ASSERT_TRUE(writer.begin());
  for (std::uint32_t i = 0; i < kRecordedPairs; ++i) {
    ASSERT_TRUE(writer.write(depth_frame(i)));
    ASSERT_TRUE(writer.write(colour_as(format, i)));
  }
  ASSERT_TRUE(writer.finish());
}

class Ros2Recording : public ::testing::TestWithParam<PixelFormat> {
 protected:
  /// Writes both files, and compares what is read of them.
  void expect_the_same(const RawCalibration& calibration) {
    const auto sink_of = [&](const char* name) {
      auto file = std::make_shared<AppendFile>(AppendFile::create(folder_ / name).value());
      return [file](std::span<const std::byte> bytes) { return file->append(bytes); };
    };
    RecordingWriter own(sink_of("own.mcap"), calibration);
    write_with(own, GetParam());
    Ros2RecordingWriter ros2(sink_of("ros2.mcap"), calibration, streams_with(GetParam()));
    write_with(ros2, GetParam());
    const Played as_own = play(folder_ / "own.mcap");
    const Played as_ros2 = play(folder_ / "ros2.mcap");
    ASSERT_EQ(as_own.frames.size(), kRecordedPairs);
    ASSERT_EQ(as_ros2.frames.size(), kRecordedPairs);
    for (std::uint32_t i = 0; i < kRecordedPairs; ++i) {
      SCOPED_TRACE(i);
      expect_same(as_own.frames[i], as_ros2.frames[i]);
      EXPECT_EQ(as_ros2.frames[i].timestamp_ns - as_ros2.frames[0].timestamp_ns, i * kPeriod_ns);
    }
  }

  static void expect_same(const Frame& own, const Frame& ros2) {
    EXPECT_EQ(own.intrinsics, ros2.intrinsics);
    ASSERT_EQ(own.depth_m.size(), ros2.depth_m.size());
    for (std::size_t i = 0; i < own.depth_m.size(); ++i) {
      ASSERT_FLOAT_EQ(own.depth_m.pixels()[i], ros2.depth_m.pixels()[i]);
    }
    ASSERT_TRUE(own.colour.has_value() && ros2.colour.has_value());
    EXPECT_EQ(own.colour->image, ros2.colour->image);
    EXPECT_EQ(own.colour->intrinsics, ros2.colour->intrinsics);
    EXPECT_TRUE(own.colour->T_colour_depth.isApprox(ros2.colour->T_colour_depth, 1e-9));
  }

  TemporaryFolder folder_;
};

TEST_P(Ros2Recording, HoldsWhatOurOwnHolds) {
  expect_the_same(raw_calibration());
}

TEST_P(Ros2Recording, HoldsDepthOfAnyUnitAndTheLenses) {
  RawCalibration calibration = raw_calibration();
  calibration.depth_unit_m = 0.00025;
  calibration.depth.distortion = {0.1, -0.05, 0.001, 0.002, 0};
  calibration.colour.distortion = {-0.2, 0.03, 0, 0, 0};
  expect_the_same(calibration);
}

INSTANTIATE_TEST_SUITE_P(Colours, Ros2Recording,
                         ::testing::Values(PixelFormat::kRgb8, PixelFormat::kBgr8, PixelFormat::kYuyv,
                                           PixelFormat::kUyvy),
                         [](const auto& format) { return std::string(to_string(format.param)); });

/// The camera's clock begins again when it is plugged in again; the bag's times do not.
TEST(Ros2RecordingClock, GoesOnWhereTheCamerasBeginsAgain) {
  TemporaryFolder folder;
  const fs::path path = folder / "ros2.mcap";
  {
    auto file = AppendFile::create(path);
    ASSERT_TRUE(file);
    Ros2RecordingWriter writer([&](std::span<const std::byte> bytes) { return file->append(bytes); }, raw_calibration(),
                               streams_with(PixelFormat::kRgb8));
    ASSERT_TRUE(writer.begin());
    for (std::uint32_t i = 0; i < 6; ++i) {
      RawFrame frame = depth_frame(i);
      if (i >= 3) frame.device_ns -= depth_frame(3).device_ns;
      ASSERT_TRUE(writer.write(frame));
    }
    ASSERT_TRUE(writer.finish());
  }
  const Played played = play(path);
  ASSERT_EQ(played.frames.size(), 6u);
  for (std::size_t i = 1; i < 6; ++i) {
    EXPECT_NEAR(static_cast<double>(played.frames[i].timestamp_ns - played.frames[i - 1].timestamp_ns), kPeriod_ns, 1e6)
        << i;
  }
}

TEST(Ros2Recorder, IsWrittenByTheRecorderWhileTheScannerSends) {
  TemporaryFolder folder;
  const fs::path path = folder / "ros2.mcap";
  const RecorderConfig config{.queue_frames = 1000, .ros2_streams = streams_with(PixelFormat::kRgb8)};
  auto recorder = Recorder::create(path, raw_calibration(), config);
  ASSERT_TRUE(recorder) << recorder.error().text();
  for (std::uint32_t i = 0; i < kRecordedPairs; ++i) {
    (*recorder)->record(depth_frame(i));
    (*recorder)->record(colour_frame(i));
  }
  (*recorder)->note_losses({});
  // What a killed process leaves: all that is older than a second, without the file's end.
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));
  fs::copy_file(path, folder / "killed.mcap");
  const auto summary = (*recorder)->finish();
  ASSERT_TRUE(summary) << summary.error().text();
  EXPECT_EQ(summary->frames, 2 * kRecordedPairs);
  EXPECT_EQ(play(path).frames.size(), kRecordedPairs);
  EXPECT_EQ(play(folder / "killed.mcap").frames.size(), kRecordedPairs);
}

}  // namespace
}  // namespace scanknit::test
