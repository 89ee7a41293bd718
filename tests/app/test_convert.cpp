// Converting, mending and pacing recordings, as a user does it.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>

#include "tests/app/scan.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

std::vector<std::string> run_arguments(const fs::path& recording, const fs::path& output) {
  return {"run", recording.string(), "-o", output.string(), "--set", "fusion.voxel_size=8mm"};
}

Outcome convert(const fs::path& recording, const std::string& target, const fs::path& output) {
  return scanknit_command({"convert", recording.string(), "-o", output.string(), "--to", target});
}

TEST(ConvertCommand, TheConvertedRecordingGivesTheSameMesh) {
  const Scan scan;
  const fs::path mcap = scan / "scan.mcap";
  const Outcome converted = convert(scan.recording(), "mcap", mcap);
  ASSERT_EQ(converted.exit_code, 0) << converted.err;
  ASSERT_EQ(scanknit_command(run_arguments(scan.recording(), scan / "a.ply")).exit_code, 0);
  for (const char* again : {"b.ply", "c.ply"}) {
    const Outcome outcome = scanknit_command(run_arguments(mcap, scan / again));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(read_text(scan / again), read_text(scan / "a.ply")) << "bit by bit";
  }
}

TEST(ConvertCommand, SaysWhatItDidAsJson) {
  const Scan scan;
  const Outcome outcome =
      scanknit_command({"convert", scan.recording().string(), "-o", (scan / "tum").string(), "--to", "tum", "--json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json json = Json::parse(outcome.out);
  EXPECT_EQ(json["frames"], kScanFrames);
  EXPECT_EQ(json["with_colour"], kScanFrames);
  EXPECT_EQ(json["with_pose"], kScanFrames);
  EXPECT_EQ(json["dropped"], 0);
  EXPECT_TRUE(json["warnings"].is_array());
}

TEST(ConvertCommand, WritesOnlyTheSharpestFrames) {
  const Scan scan;
  const auto chosen = [&](const std::string& target, const std::string& count) {
    return scanknit_command({"convert", scan.recording().string(), "-o", (scan / (target + count)).string(), "--to",
                             target, "--frames", count, "--json"});
  };
  for (const char* target : {"nerfstudio", "colmap"}) {
    const Outcome outcome = chosen(target, "1");
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(Json::parse(outcome.out)["frames"], 1);
  }
  const Outcome refused = chosen("tum", "2");
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.err.find("--frames: only with --to nerfstudio or --to colmap"), std::string::npos) << refused.err;
  EXPECT_EQ(chosen("nerfstudio", "0").exit_code, 2);
}

TEST(ConvertCommand, RefusesATargetThatDoesNotExist) {
  const Scan scan;
  const Outcome outcome = convert(scan.recording(), "betamax", scan / "x");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.err.find("--to: expected one of mcap, tum"), std::string::npos) << outcome.err;
}

TEST(ConvertCommand, LeavesNoFileWhenTheDiskIsFull) {
  const Scan scan;
  const fs::path mcap = scan / "scan.mcap";
  const Outcome outcome = scanknit_command({"convert", scan.recording().string(), "-o", mcap.string(), "--to", "mcap"},
                                           std::uintmax_t{20'000});
  EXPECT_EQ(outcome.exit_code, 8) << outcome.err;
  EXPECT_FALSE(fs::exists(mcap));
}

TEST(RepairCommand, MendsATornRecordingAndSaysWhatIsLost) {
  const Scan scan({.frames = 40, .width = 320, .height = 240});  // several chunks
  const fs::path mcap = scan / "scan.mcap";
  ASSERT_EQ(convert(scan.recording(), "mcap", mcap).exit_code, 0);
  fs::resize_file(mcap, fs::file_size(mcap) * 2 / 3);
  const Outcome torn = scanknit_command({"info", mcap.string()});
  EXPECT_EQ(torn.exit_code, 0);
  EXPECT_NE(torn.out.find("torn"), std::string::npos) << torn.out;
  ASSERT_EQ(scanknit_command({"run", mcap.string(), "-o", (scan / "out").string()}).exit_code, 0);
  const Json report = Json::parse(read_text(scan / "out" / "report.json"));
  ASSERT_EQ(report["warnings"].size(), 1u);
  EXPECT_NE(report["warnings"][0].get<std::string>().find("torn"), std::string::npos);

  const Outcome repaired = scanknit_command({"repair", mcap.string()});
  ASSERT_EQ(repaired.exit_code, 0) << repaired.err;
  EXPECT_NE(repaired.out.find("ends early"), std::string::npos) << repaired.out;
  const Json info = Json::parse(scanknit_command({"info", mcap.string(), "--json"}).out);
  EXPECT_EQ(info["format"], "mcap");
  EXPECT_TRUE(info["warnings"].empty());
  EXPECT_GT(info["frames"], 10);
  EXPECT_LT(info["frames"], 40);
}

TEST(RepairCommand, OverwritesNoOtherRecording) {
  const Scan scan({.frames = 4});
  const fs::path mcap = scan / "scan.mcap", other = scan / "other.mcap";
  ASSERT_EQ(convert(scan.recording(), "mcap", mcap).exit_code, 0);
  std::ofstream(other) << "mine";
  const Outcome refused = scanknit_command({"repair", mcap.string(), "-o", other.string()});
  EXPECT_EQ(refused.exit_code, 8) << refused.err;
  EXPECT_EQ(fs::file_size(other), 4u);
}

TEST(RepairCommand, MendsWhereALinkLeads) {
  const Scan scan({.frames = 4});
  const fs::path mcap = scan / "scan.mcap", link = scan / "link.mcap";
  ASSERT_EQ(convert(scan.recording(), "mcap", mcap).exit_code, 0);
  fs::resize_file(mcap, fs::file_size(mcap) - 10);
  fs::create_symlink(mcap, link);
  ASSERT_EQ(scanknit_command({"repair", link.string()}).exit_code, 0);
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_TRUE(Json::parse(scanknit_command({"info", mcap.string(), "--json"}).out)["warnings"].empty());
}

TEST(RepairCommand, RefusesWhatIsNoRecording) {
  const Scan scan;
  EXPECT_EQ(scanknit_command({"repair", scan.depth_picture(0).string()}).exit_code, 4);
  EXPECT_EQ(scanknit_command({"repair", (scan / "nothing.mcap").string()}).exit_code, 4);
  ASSERT_EQ(::mkfifo((scan / "pipe.mcap").c_str(), 0600), 0);
  EXPECT_EQ(scanknit_command({"repair", (scan / "pipe.mcap").string()}).exit_code, 4);
}

TEST(Pace, RealtimeTakesAsLongAsTheRecording) {
  const Scan scan;
  const Outcome outcome = scan.run({"--pace", "realtime"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json report = scan.report();
  EXPECT_EQ(report["frames"]["fused"], kScanFrames);
  constexpr double kLastFrame_ms = (kScanFrames - 1) * 1000.0 / 30;
  EXPECT_GT(report["total_ms"].get<double>(), kLastFrame_ms * 0.99);
}

// Voxels so fine that few computers keep up with the recording's clock.
TEST(Pace, AnyGivesTheSameMesh) {
  const Scan scan;
  const auto mesh_at = [&](const std::string& pace) {
    const Outcome outcome = scan.run({"--pace", pace, "--set", "fusion.voxel_size=0.5mm"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return read_text(scan.output() / "model.ply");
  };
  const std::string mesh = mesh_at("fast");
  EXPECT_FALSE(mesh.empty());
  EXPECT_TRUE(mesh_at("realtime") == mesh);
}

}  // namespace
}  // namespace scanknit
