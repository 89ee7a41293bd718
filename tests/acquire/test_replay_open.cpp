// Opening: which layout is recognised where, and what is said when none is.
#include <gtest/gtest.h>

#include <fstream>
#include <stop_token>

#include "acquire/recording_format.h"
#include "acquire/replay/folder.h"
#include "test_replay_support.h"
#include "tests/support/text.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;
using ::testing::Test;

TEST(NaturalOrder, ComparesDigitsAsNumbers) {
  EXPECT_TRUE(natural_less("frame2", "frame10"));
  EXPECT_FALSE(natural_less("frame10", "frame2"));
  EXPECT_TRUE(natural_less("a", "a1"));
  EXPECT_TRUE(natural_less("99999999999999999999999", "100000000000000000000000"));
}

TEST(OpenRecording, SaysWhatItLooksForInAnEmptyFolder) {
  const TemporaryFolder folder;
  const std::string error = open_error(folder.path());
  for (const char* layout :
       {"7-scenes",      "tum",         "open3d",  "nerfstudio", "phone-lidar",   "pcd",      "pclzf",
        "fakenect",      "mcap",        "ros2",    "ros1",       "realsense-bag", "oni",      "sens",
        "stray-scanner", "arkitscenes", "polycam", "replica",    "bop",           "record3d", "azure-mkv"}) {
    EXPECT_TRUE(contains(error, layout)) << error;
  }
}

TEST(OpenRecording, NamesAPathThatIsNotThere) {
  EXPECT_TRUE(contains(open_error("/nowhere/at/all"), "/nowhere/at/all: no such file or folder"));
}

TEST(OpenRecording, TakesTheOneFileThatIsARecording) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "notes.mcap") << "no recording";
  std::filesystem::create_directory(folder.path() / "scan");
  // As `capture -o scan` leaves it, beside the mesh: without one frame, which is what the message then says.
  std::ofstream(folder.path() / "scan" / "model.ply") << "ply";
  std::ofstream(folder.path() / "scan" / "recording.mcap", std::ios::binary).write("\x89MCAP0\r\n", 8);
  const std::string error = open_error(folder.path());
  EXPECT_TRUE(contains(error, "recording.mcap: an MCAP file, but not a recording of ours")) << error;
  std::ofstream(folder.path() / "scan" / "second.mcap", std::ios::binary).write("\x89MCAP0\r\n", 8);
  EXPECT_TRUE(contains(open_error(folder.path()), "holds 2 recordings"));
}

TEST(OpenRecording, TakesTheOnlyRecordingBelow) {
  const TemporaryFolder folder;
  write_seven_scenes(folder / "scene/seq-01", 1);
  const auto source = open_recording(folder.path(), {});
  ASSERT_TRUE(source) << source.error().text();
  EXPECT_EQ((*source)->info().folder, folder.path() / "scene" / "seq-01");
}

TEST(OpenRecording, AsksWhichOfSeveralBelow) {
  const TemporaryFolder folder;
  write_seven_scenes(folder / "seq-01", 1);
  write_seven_scenes(folder / "seq-02", 1);
  const std::string error = open_error(folder.path());
  EXPECT_TRUE(contains(error, "seq-01") && contains(error, "seq-02")) << error;
}

TEST(OpenRecording, TakesAFileForItsFolder) {
  const TemporaryFolder folder;
  write_seven_scenes(folder.path(), 3);
  EXPECT_EQ(play(folder / seven_scenes_name(1, "depth.png")).frames.size(), 3u);
}

TEST(OpenRecording, TakesNoOtherFileForTheOneThatIsNamed) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "good.mcap", std::ios::binary).write("\x89MCAP0\r\n", 8);
  for (const char* name : {"empty.mcap", "notes.txt", "torn.bag"}) {
    std::ofstream(folder.path() / name) << (name == std::string("empty.mcap") ? "" : "hello");
    const std::string error = open_error(folder.path() / name);
    EXPECT_TRUE(contains(error, name) && contains(error, "no recording of a known layout")) << error;
    EXPECT_FALSE(contains(error, "good.mcap")) << error;
  }
}

TEST(OpenRecording, SaysWhatPicturesWithMasksAreGoodFor) {
  const TemporaryFolder folder;
  write_text(folder / "color/000000.png", "");
  EXPECT_FALSE(contains(open_error(folder.path()), "acquire.geometry=silhouettes"));
  write_text(folder / "masks/000000.png", "");
  EXPECT_TRUE(contains(open_error(folder.path()), "acquire.geometry=silhouettes"));
}

TEST(OpenRecording, SaysOfAFileThatItIsNoRecordingWhateverLiesAFolderUp) {
  const TemporaryFolder folder;
  AcquireConfig config;
  config.limits.max_frames = 1;
  for (int i = 0; i < 6; ++i) write_text(folder / ("more than one frame has " + std::to_string(i)), "");
  write_text(folder / "below" / "notes.txt", "hello");
  const std::string error = open_error(folder / "below/notes.txt", config);
  EXPECT_TRUE(contains(error, "notes.txt: no recording of a known layout")) << error;
}

TEST(OpenRecording, ReadsTheCameraOneFolderUp) {
  const TemporaryFolder folder;
  write_seven_scenes(folder / "seq-01", 1);
  fs::rename(folder / "seq-01/camera-intrinsics.txt", folder / "camera-intrinsics.txt");
  const Played played = play(folder / "seq-01");
  ASSERT_EQ(played.frames.size(), 1u);
  EXPECT_EQ(played.frames[0].intrinsics, (CameraIntrinsics{kWidth, kHeight, 100, 100, 3.5, 2.5}));
}

TEST(OpenRecording, SaysHowToGiveMissingIntrinsics) {
  const TemporaryFolder folder;
  write_seven_scenes(folder.path(), 1);
  fs::remove(folder / "camera-intrinsics.txt");
  EXPECT_TRUE(contains(open_error(folder.path()), "acquire.intrinsics=[525,525,319.5,239.5]"));
}

TEST(OpenRecording, RefusesACameraFileThatIsNone) {
  const TemporaryFolder folder;
  write_seven_scenes(folder.path(), 1);
  write_text(folder / "camera-intrinsics.txt", "0 0 3\n0 0 2\n0 0 1\n");
  EXPECT_TRUE(contains(open_error(folder.path()), "camera-intrinsics.txt: not a camera matrix"));
}

TEST(OpenRecording, LetsTheConfigurationOverrideTheCamera) {
  const TemporaryFolder folder;
  write_seven_scenes(folder.path(), 1);
  AcquireConfig config;
  config.intrinsics = CameraModel{{0, 0, 50, 60, 1, 2}, {}};
  const Played played = play(folder.path(), config);
  ASSERT_EQ(played.frames.size(), 1u);
  EXPECT_EQ(played.frames[0].intrinsics, (CameraIntrinsics{kWidth, kHeight, 50, 60, 1, 2}));
}

TEST(OpenRecording, LetsTheConfigurationOverrideTheDepthScale) {
  const TemporaryFolder folder;
  write_seven_scenes(folder.path(), 1);
  AcquireConfig config;
  config.depth_scale = 500;
  EXPECT_EQ(play(folder.path(), config).frames.at(0).depth_m.at(0, 0), 2.0F);
}

TEST(OpenRecording, RefusesADepthScaleOfZero) {
  const TemporaryFolder folder;
  write_seven_scenes(folder.path(), 1);
  AcquireConfig config;
  config.depth_scale = 0.0;
  EXPECT_TRUE(contains(open_error(folder.path(), config), "acquire.depth_scale"));
}

TEST(OpenRecording, ObeysTheNamedFormat) {
  const TemporaryFolder folder;
  write_seven_scenes(folder.path(), 1);
  AcquireConfig config;
  config.format = RecordingFormat::kTum;
  const std::string error = open_error(folder.path(), config);
  EXPECT_TRUE(contains(error, "tum: depth.txt") && !contains(error, "pclzf")) << error;
}

TEST(OpenRecording, SelectsFromToAndEvery) {
  const TemporaryFolder folder;
  write_seven_scenes(folder.path(), 10);
  AcquireConfig config;
  config.from = 2;
  config.to = 8;
  config.every = 3;
  const Played played = play(folder.path(), config);
  ASSERT_EQ(played.frames.size(), 3u);
  EXPECT_EQ(played.frames[0].sequence, 2u);
  EXPECT_EQ(played.frames[2].sequence, 8u);
}

TEST(OpenRecording, EveryBeyondTheEndGivesOneFrame) {
  const TemporaryFolder folder;
  write_seven_scenes(folder.path(), 3);
  AcquireConfig config;
  config.from = 1;
  config.every = std::numeric_limits<std::size_t>::max();
  EXPECT_EQ(play(folder.path(), config).frames.size(), 1u);
}

TEST(OpenRecording, SaysThatASelectionIsEmpty) {
  const TemporaryFolder folder;
  write_seven_scenes(folder.path(), 3);
  AcquireConfig config;
  config.from = 3;
  EXPECT_TRUE(contains(open_error(folder.path(), config), "selects no frame: the recording has 3"));
}

TEST(Replay, EndsWhenAskedToStop) {
  const TemporaryFolder folder;
  write_seven_scenes(folder.path(), 2);
  auto source = open_recording(folder.path(), {});
  ASSERT_TRUE(source);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_TRUE(std::holds_alternative<EndOfStream>((*source)->next(stop.get_token())));
}

TEST(Replay, PassesOverHiddenFiles) {
  const TemporaryFolder folder;
  write_seven_scenes(folder.path(), 2);
  const auto listed = list_folder(folder.path(), Limits{});
  ASSERT_TRUE(listed);
  for (const std::string& name : listed->files) write_text(folder / ("._" + name), "what a Mac leaves");
  fs::create_directories(folder / ".git");
  EXPECT_EQ(list_folder(folder.path(), Limits{})->files, listed->files);
  EXPECT_EQ(list_folder(folder.path(), Limits{})->folders, listed->folders);
}

TEST(OpenRecording, OfSweepsSaysWhichCommandsReadThem) {
  const TemporaryFolder folder;
  EXPECT_FALSE(contains(open_error(folder.path()), "only run and info"));
  write_text(folder / "velodyne/000000.bin", "");
  EXPECT_TRUE(contains(open_error(folder.path()), "sweeps of a LiDAR: only run and info read them"));
  write_text(folder / "walk.pcap", "");
  EXPECT_TRUE(contains(open_error(folder / "walk.pcap"), "sweeps of a LiDAR"));
}

TEST(Replay, StaysAtItsEnd) {
  const TemporaryFolder folder;
  write_seven_scenes(folder.path(), 1);
  auto source = open_recording(folder.path(), {});
  ASSERT_TRUE(source);
  EXPECT_TRUE(std::holds_alternative<Frame>((*source)->next({})));
  EXPECT_TRUE(std::holds_alternative<EndOfStream>((*source)->next({})));
  EXPECT_TRUE(std::holds_alternative<EndOfStream>((*source)->next({})));
}

}  // namespace
}  // namespace scanknit::test
