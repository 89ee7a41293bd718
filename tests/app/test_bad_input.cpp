// Bad input, end to end: one damaged recording a test.
#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <sstream>

#include "tests/app/scan.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

void write_text(const fs::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << text;
}

/// Rewrites line `number` (from 0) of a text file.
void replace_line(const fs::path& path, std::size_t number, const std::string& replacement) {
  std::istringstream lines(read_text(path));
  std::string text, line;
  for (std::size_t i = 0; std::getline(lines, line); ++i) text += (i == number ? replacement : line) + "\n";
  write_text(path, text);
}

/// One frame of the recording cannot be used: it is dropped with this reason, the file is named, the run goes on.
void expect_one_dropped(const Scan& scan, const std::string& reason, const std::string& named) {
  const Outcome outcome = scan.run();
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json frames = scan.report()["frames"];
  EXPECT_EQ(frames["dropped"], 1) << frames.dump(1);
  EXPECT_EQ(frames["dropped_by_reason"][reason], 1) << frames.dump(1);
  EXPECT_EQ(frames["fused"], kScanFrames - 1);
  EXPECT_NE(outcome.err.find(named), std::string::npos) << outcome.err;
}

void expect_nothing_meshed(const Scan& scan, const Outcome& outcome, int exit_code) {
  EXPECT_EQ(outcome.exit_code, exit_code) << outcome.err;
  for (const char* name : {"model.glb", "model.ply", "preview.png"}) EXPECT_FALSE(fs::exists(scan.output() / name));
  const Json report = scan.report();
  EXPECT_EQ(report["exit_code"], exit_code);
  EXPECT_NE(report["status"], "ok");
}

TEST(BadFrame, AMissingPictureIsDropped) {
  const Scan scan;
  const fs::path picture = scan.depth_picture(3);
  const fs::path last = scan.depth_picture(kScanFrames - 1);
  fs::remove(picture);
  // The layout numbers its frames by its files: the frame is there by its pose and colour only.
  const Outcome outcome = scan.run();
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_LT(scan.report()["frames"]["fused"].get<int>(), kScanFrames);
}

TEST(BadFrame, AnEmptyPictureIsDropped) {
  const Scan scan;
  write_text(scan.depth_picture(3), "");
  expect_one_dropped(scan, "unreadable", scan.depth_picture(3).filename().string());
}

TEST(BadFrame, ATruncatedPictureIsDropped) {
  const Scan scan;
  const std::string whole = read_text(scan.depth_picture(3));
  write_text(scan.depth_picture(3), whole.substr(0, whole.size() / 2));
  expect_one_dropped(scan, "unreadable", scan.depth_picture(3).filename().string());
}

TEST(BadFrame, APictureThatIsNoPngIsDropped) {
  const Scan scan;
  write_text(scan.depth_picture(3), "GIF89a and so on");
  expect_one_dropped(scan, "unreadable", scan.depth_picture(3).filename().string());
}

TEST(BadFrame, APictureOfAbsurdDimensionsIsDropped) {
  const Scan scan;
  std::string png = read_text(scan.depth_picture(3));
  for (const std::size_t byte : {16u, 20u})
    png.replace(byte, 4, std::string("\x7f\xff\xff\xff"));  // IHDR width, height
  write_text(scan.depth_picture(3), png);
  expect_one_dropped(scan, "unreadable", scan.depth_picture(3).filename().string());
}

TEST(BadFrame, APictureOfAnotherSizeIsDropped) {
  const Scan scan;
  const Scan larger({.width = 128, .height = 96});
  fs::copy_file(larger.depth_picture(3), scan.depth_picture(3), fs::copy_options::overwrite_existing);
  expect_one_dropped(scan, "size_mismatch", scan.depth_picture(3).filename().string());
}

TEST(BadFrame, APoseThatIsNotANumberIsDropped) {
  const Scan scan;
  replace_line(scan.recording() / "trajectory.log", 3 * 5 + 1, "nan 0 0 0");
  expect_one_dropped(scan, "bad_pose", "trajectory.log");
}

TEST(BadFrame, APoseThatIsNotRigidIsDropped) {
  const Scan scan;
  replace_line(scan.recording() / "trajectory.log", 3 * 5 + 1, "2 0 0 0");
  expect_one_dropped(scan, "bad_pose", "trajectory.log");
}

TEST(BadFrame, APoseBeyondTheReachOfTheVolumeIsDropped) {
  const Scan scan;
  replace_line(scan.recording() / "trajectory.log", 3 * 5 + 1, "1 0 0 1e8");
  replace_line(scan.recording() / "trajectory.log", 3 * 5 + 2, "0 1 0 0");
  replace_line(scan.recording() / "trajectory.log", 3 * 5 + 3, "0 0 1 0");
  expect_one_dropped(scan, "bad_pose", "too far");
}

TEST(BadRecording, NoUsableFrameExitsWith4) {
  const Scan scan;
  for (std::size_t i = 1; i < kScanFrames; ++i) write_text(scan.depth_picture(i), "");
  const Outcome outcome = scan.run({"--from", "1"});
  expect_nothing_meshed(scan, outcome, 4);
  EXPECT_NE(outcome.err.find("no usable frame"), std::string::npos) << outcome.err;
}

TEST(BadRecording, FramesThatAreNotThereExitWith4) {
  const Scan scan;
  expect_nothing_meshed(scan, scan.run({"--from", "1000"}), 4);
}

TEST(BadRecording, AnEmptyFolderExitsWith4AndNamesTheKnownLayouts) {
  const Scan scan;
  fs::create_directories(scan / "empty");
  const Outcome outcome = scanknit_command({"run", (scan / "empty").string(), "-o", scan.output().string()});
  expect_nothing_meshed(scan, outcome, 4);
}

TEST(BadRecording, MissingIntrinsicsSayHowToGiveThem) {
  const Scan scan;
  fs::remove(scan.recording() / "camera_intrinsic.json");
  const Outcome outcome = scan.run();
  expect_nothing_meshed(scan, outcome, 4);
  EXPECT_NE(outcome.err.find("acquire.intrinsics"), std::string::npos) << outcome.err;
  EXPECT_EQ(scan.run({"--set", "acquire.intrinsics=[78.75, 78.75, 47.5, 35.5]", "--set", "acquire.depth_scale=10000"})
                .exit_code,
            0);
}

TEST(BadRecording, AnEmptyMeshExitsWith7) {
  const Scan scan;
  const Outcome outcome = scan.run({"--set", "extract.isovalue=7"});
  expect_nothing_meshed(scan, outcome, 7);
  EXPECT_NE(outcome.err.find("extract.isovalue"), std::string::npos) << outcome.err;
}

/// A fifth above the finest that fits, and as much again for the count, which is on the safe side.
constexpr double kCoarser = 1.3;

/// What a run of half a millimetre is told to use within a budget, in millimetres; 0: nothing.
double advised_size_mm(const Scan& scan, const std::string& budget, std::string* message = nullptr) {
  const Outcome outcome = scan.run(
      {"--set", "fusion.bricks=off", "--set", "fusion.voxel_size=0.5mm", "--set", "fusion.memory_budget=" + budget});
  EXPECT_EQ(outcome.exit_code, 9) << outcome.err;
  EXPECT_FALSE(fs::exists(scan.output() / "model.glb"));
  if (message != nullptr) *message = outcome.err;
  const std::string option = ": set fusion.voxel_size=";
  const std::size_t at = outcome.err.find(option);
  return at == std::string::npos ? 0 : std::stod(outcome.err.substr(at + option.size()));
}

/// The volume takes all frames without being full.
bool holds_all(const Scan& scan, const std::string& budget, double size_mm) {
  const Outcome outcome =
      scan.run({"--set", "fusion.bricks=off", "--set", "fusion.voxel_size=" + std::to_string(size_mm) + "mm", "--set",
                "fusion.memory_budget=" + budget});
  const bool is_whole = outcome.exit_code == 0 && scan.report()["volume"]["is_budget_reached"] == false;
  fs::remove_all(scan.output());
  return is_whole;
}

TEST(Budget, AVolumeThatWouldNotFitIsRefusedWithTheFinestRoundSizeThatWould) {
  const Scan scan;
  for (const char* budget : {"36MiB", "48MiB", "64MiB", "96MiB", "152MiB"}) {
    const double size_mm = advised_size_mm(scan, budget);
    ASSERT_GT(size_mm, 0) << budget;
    EXPECT_TRUE(holds_all(scan, budget, size_mm)) << budget << ' ' << size_mm;
    EXPECT_FALSE(holds_all(scan, budget, size_mm / kCoarser)) << budget << ' ' << size_mm;
  }
}

TEST(Budget, SaysWhenItHasNotLookedAtAllFrames) {
  const Scan scan({.frames = 60});
  std::string message;
  const double size_mm = advised_size_mm(scan, "96MiB", &message);
  EXPECT_NE(message.find("would fit, judging by 20 of its 60 frames"), std::string::npos) << message;
  EXPECT_TRUE(holds_all(scan, "96MiB", size_mm)) << size_mm;
}

TEST(Budget, ThatHoldsNothingIsRefusedAndTheLeastIsNamedAndTaken) {
  const Scan scan;
  const Outcome too_little = scan.run({"--set", "fusion.memory_budget=7MiB"});
  EXPECT_EQ(too_little.exit_code, 3) << too_little.err;
  EXPECT_NE(too_little.err.find("8.."), std::string::npos) << too_little.err;
  EXPECT_EQ(scan.run({"--set", "fusion.memory_budget=8MiB", "--set", "fusion.voxel_size=2cm"}).exit_code, 0);
}

TEST(BadOutput, AnUnwritableFolderExitsWith8BeforeAnyFrameIsRead) {
  const Scan scan;
  const Outcome outcome = scan.run({"-o", "/proc/no/such/folder"});
  EXPECT_EQ(outcome.exit_code, 8) << outcome.err;
  EXPECT_EQ(outcome.err.find("fusing"), std::string::npos);
  write_text(scan / "file", "in the way");
  EXPECT_EQ(scan.run({"-o", (scan / "file" / "model.glb").string()}).exit_code, 8);
}

TEST(BadOutput, AFullDiskExitsWith8AndLeavesTheOldFileAlone) {
  const Scan scan;
  const fs::path model = scan / "model.glb";
  write_text(model, "the old model");
  constexpr std::uintmax_t kDiskBytes = 1000;
  const Outcome outcome = scanknit_command(
      {"run", scan.recording().string(), "-o", model.string(), "--set", "fusion.voxel_size=8mm"}, kDiskBytes);
  EXPECT_EQ(outcome.exit_code, 8) << outcome.err;
  EXPECT_EQ(read_text(model), "the old model");
  for (const auto& entry : fs::directory_iterator(model.parent_path())) {
    EXPECT_FALSE(entry.path().filename().string().starts_with(".")) << "left behind: " << entry.path();
  }
}

}  // namespace
}  // namespace scanknit
