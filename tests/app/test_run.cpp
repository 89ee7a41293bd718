// The main job on a synthetic recording: what comes out.
#include <gtest/gtest.h>
#include <pty.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <thread>

#include "tests/app/scan.h"
#include "tests/support/places.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

TEST(Run, LeavesTheFilesThatTheHelpPromises) {
  const Scan scan;
  const Outcome outcome = scan.run();
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  for (const char* name : {"model.glb", "model.ply", "preview.png", "error.png", "coverage.png", "report.json",
                           "report.html", "trajectory.txt"}) {
    EXPECT_TRUE(fs::is_regular_file(scan.output() / name)) << name;
    EXPECT_GT(fs::file_size(scan.output() / name), 0u) << name;
  }
}

TEST(Run, TheMeshFitsTheDepthFramesOfANoiselessScan) {
  const Scan scan({.width = 320, .height = 240});
  ASSERT_EQ(scan.run().exit_code, 0);
  const Json fit = scan.report()["fit"];
  EXPECT_EQ(fit["frames"], kScanFrames);
  EXPECT_GT(fit["seen_share"].get<double>(), 0.95);
  constexpr double kMedianM = 0.001;  // an eighth of a voxel
  EXPECT_LT(fit["median_m"].get<double>(), kMedianM);
  EXPECT_GT(fit["median_m"].get<double>(), 0);
  EXPECT_EQ(scan.report()["holes"]["count"] == 0, scan.report()["mesh"]["is_closed"].get<bool>());
}

TEST(Run, WarnsOfWhatIsForGlbOnlyWhereNoneIsWritten) {
  const Scan scan;
  const std::vector<std::string> glb_only = {"--quantize", "--compress", "--set", "export.material=unlit"};
  const auto run = [&](const std::string& output) {
    std::vector<std::string> arguments = glb_only;
    arguments.insert(arguments.end(), {"-o", (scan / output).string()});
    return scan.run(arguments);
  };
  const std::string warning =
      "export.quantize, export.compress and export.material have no effect because no GLB file is written";
  const Outcome ply = run("model.ply");
  EXPECT_EQ(ply.exit_code, 0) << ply.err;
  EXPECT_NE(ply.err.find(warning), std::string::npos) << ply.err;
  const Outcome glb = run("model.glb");
  EXPECT_EQ(glb.exit_code, 0) << glb.err;
  EXPECT_EQ(glb.err.find("no effect"), std::string::npos) << glb.err;
  ASSERT_EQ(scan.run({"--quantize", "--set", "export.formats=[ply]"}).exit_code, 0);
  EXPECT_EQ(scan.report()["warnings"], Json::array({"export.quantize has no effect because no GLB file is written"}));
}

TEST(Run, WithoutPicturesThePageSaysSo) {
  const Scan scan;
  ASSERT_EQ(scan.run({"--set", "export.preview=false"}).exit_code, 0);
  EXPECT_FALSE(fs::exists(scan.output() / "error.png"));
  EXPECT_NE(read_text(scan.output() / "report.html").find("There are no pictures"), std::string::npos);
}

TEST(Report, IsDrawnAgainWhereverTheFolderIs) {
  const Scan scan;
  ASSERT_EQ(scan.run().exit_code, 0);
  const std::string page = read_text(scan.output() / "report.html");
  fs::rename(scan.output(), scan / "moved");
  fs::remove(scan / "moved/report.html");
  const Outcome outcome = scanknit_command({"report", (scan / "moved").string()});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.out, (scan / "moved/report.html").string() + "\n");
  EXPECT_TRUE(read_text(scan / "moved/report.html") == page);
}

TEST(Report, IsDrawnAgainFromAReportThatLiesElsewhere) {
  const Scan scan;
  const std::string elsewhere = (scan / "elsewhere.json").string();
  ASSERT_EQ(scan.run({"--report", elsewhere}).exit_code, 0);
  const fs::path page_file = scan.output() / "report.html";
  const std::string page = read_text(page_file);
  fs::remove(page_file);
  const Outcome unsaid = scanknit_command({"report", scan.output().string()});
  EXPECT_EQ(unsaid.exit_code, 4);
  EXPECT_NE(unsaid.err.find("--report FILE"), std::string::npos) << unsaid.err;
  const Outcome said = scanknit_command({"report", scan.output().string(), "--report", elsewhere});
  EXPECT_EQ(said.exit_code, 0) << said.err;
  EXPECT_TRUE(read_text(page_file) == page);
}

TEST(Report, OfAJsonFileThePageLiesBesideIt) {
  const Scan scan;
  ASSERT_EQ(scan.run().exit_code, 0);
  const fs::path page_file = scan.output() / "report.html";
  const std::string page = read_text(page_file);
  fs::remove(page_file);
  const Outcome outcome = scanknit_command({"report", (scan.output() / "report.json").string()});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.out, page_file.string() + "\n");
  EXPECT_TRUE(read_text(page_file) == page);
  EXPECT_EQ(scanknit_command({"report", page_file.string()}).exit_code, 4);  // would be written over itself
  EXPECT_TRUE(read_text(page_file) == page);
}

TEST(Report, OfAFolderWithoutOneSaysWhatWasExpected) {
  const Scan scan;
  for (const auto& folder : {scan.recording(), scan / "absent"}) {
    const Outcome outcome = scanknit_command({"report", folder.string()});
    EXPECT_EQ(outcome.exit_code, 4);
    EXPECT_NE(outcome.err.find(folder.string()), std::string::npos) << outcome.err;
  }
  std::ofstream(scan / "recording" / "report.json") << "{broken";
  EXPECT_EQ(scanknit_command({"report", scan.recording().string()}).exit_code, 4);
  std::ofstream(scan / "recording" / "report.json") << "{}";
  const Outcome empty = scanknit_command({"report", scan.recording().string()});
  EXPECT_EQ(empty.exit_code, 4);
  EXPECT_NE(empty.err.find("no report"), std::string::npos) << empty.err;
  EXPECT_FALSE(fs::exists(scan.recording() / "report.html"));
}

TEST(Run, PrintsAFewReadableLines) {
  const Scan scan;
  const std::string out = scan.run().out;
  for (const char* word : {"Frames", "Volume", "voxels of 8 mm", "Mesh", "triangles", "Seconds", "Written", "Next"}) {
    EXPECT_NE(out.find(word), std::string::npos) << word << " in\n" << out;
  }
  EXPECT_LT(std::count(out.begin(), out.end(), '\n'), 20);
}

// Ctrl-C ends `scanknit capture ... 2>&1 | tee log` on both sides.
TEST(Run, ContinuesWhenThePipeIsClosed) {
  const Scan scan;
  const std::string command = test::kProgram + " run '" + scan.recording().string() + "' -o '" +
                              scan.output().string() + "' --set fusion.voxel_size=8mm 2>&1 | true";
  EXPECT_EQ(std::system(command.c_str()), 0) << "of `true`";
  EXPECT_TRUE(fs::exists(scan.output() / "model.glb"));
  EXPECT_TRUE(fs::exists(scan.output() / "report.json"));
}

TEST(Run, ASphereComesOutClosedManifoldAndOfTheRightSize) {
  const Scan scan;
  ASSERT_EQ(scan.run().exit_code, 0);
  const Json mesh = scan.report()["mesh"];
  EXPECT_EQ(mesh["non_manifold_edges"], 0);
  EXPECT_EQ(mesh["non_manifold_vertices"], 0);
  EXPECT_EQ(mesh["components"], 1);
  constexpr double kDiameterM = 0.2;
  constexpr double kToleranceM = 0.008;  // one voxel
  for (int axis = 0; axis < 3; ++axis) {
    const double side = mesh["bounds_m"][1][axis].get<double>() - mesh["bounds_m"][0][axis].get<double>();
    EXPECT_NEAR(side, kDiameterM, kToleranceM);
  }
}

TEST(Run, TheReportHasEveryKeyOfItsSchema) {
  const Scan scan;
  ASSERT_EQ(scan.run().exit_code, 0);
  const Json report = scan.report();
  for (const char* pointer : {"/frames/read",
                              "/frames/fused",
                              "/frames/dropped",
                              "/frames/lost",
                              "/frames/dropped_by_reason",
                              "/stages/acquire/total_ms",
                              "/stages/filter/median_ms",
                              "/stages/track/p95_ms",
                              "/stages/raycast/total_ms",
                              "/stages/integrate/total_ms",
                              "/stages/integrate/peak_rss_mib",
                              "/stages/extract/total_ms",
                              "/stages/export/total_ms",
                              "/total_ms",
                              "/peak_rss_mib",
                              "/volume/active_voxels",
                              "/volume/blocks",
                              "/volume/memory_mib",
                              "/mesh/vertices",
                              "/mesh/triangles",
                              "/mesh/components",
                              "/mesh/boundary_edges",
                              "/mesh/non_manifold_edges",
                              "/mesh/non_manifold_vertices",
                              "/mesh/euler",
                              "/mesh/bounds_m",
                              "/extract/cases",
                              "/config/fusion/voxel_size",
                              "/version"}) {
    EXPECT_TRUE(report.contains(Json::json_pointer(pointer))) << pointer;
  }
  EXPECT_EQ(report["frames"]["fused"], kScanFrames);
  EXPECT_EQ(report["status"], "ok");
  EXPECT_GT(report["peak_rss_mib"].get<double>(), 0);
  EXPECT_GT(report["stages"]["integrate"]["total_ms"].get<double>(), 0);
  EXPECT_GT(report["stages"]["integrate"]["peak_rss_mib"].get<double>(), 0);
  EXPECT_LE(report["stages"]["integrate"]["peak_rss_mib"], report["peak_rss_mib"]);
  EXPECT_EQ(report["config"]["fusion"]["voxel_size"], 0.008);
}

TEST(Run, JsonGoesToStdoutAndNothingElseDoes) {
  const Scan scan;
  const Outcome outcome = scan.run({"--json"});
  const Json printed = Json::parse(outcome.out, nullptr, false);
  ASSERT_TRUE(printed.is_object()) << outcome.out;
  EXPECT_EQ(printed["mesh"], scan.report()["mesh"]);
}

TEST(Run, QuietSaysNothingWhenAllIsWell) {
  const Scan scan;
  const Outcome outcome = scan.run({"--quiet"});
  EXPECT_EQ(outcome.out + outcome.err, "");
}

TEST(Run, OneFileIsOneFile) {
  const Scan scan;
  for (const char* name : {"a.glb", "a.ply", "a.obj", "a.STL", "a.3mf"}) {
    ASSERT_EQ(scan.run({"-o", (scan / name).string()}).exit_code, 0) << name;
    EXPECT_TRUE(fs::exists(scan / name)) << name;
  }
  EXPECT_FALSE(fs::exists(scan.output()));
  EXPECT_FALSE(fs::exists(scan / "report.json"));
}

TEST(Run, ReportTrajectoryAndVolumeGoWhereTheyAreNamed) {
  const Scan scan;
  const Outcome outcome =
      scan.run({"-o", (scan / "a.ply").string(), "--report", (scan / "r.json").string(), "--trajectory",
                (scan / "t.txt").string(), "--save-volume", (scan / "v.vdb").string()});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(Json::accept(read_text(scan / "r.json")));
  const std::string trajectory = read_text(scan / "t.txt");
  EXPECT_EQ(std::count(trajectory.begin(), trajectory.end(), '\n'), kScanFrames);
  EXPECT_GT(fs::file_size(scan / "v.vdb"), 0u);
}

TEST(Run, SelectsFrames) {
  const Scan scan;
  ASSERT_EQ(scan.run({"--from", "2", "--to", "9", "--every", "3"}).exit_code, 0);
  EXPECT_EQ(scan.report()["frames"]["fused"], 3);  // 2, 5, 8
}

TEST(Run, TheSavedVolumeIsTheSameBytesForAnyNumberOfThreadsButForItsId) {
  constexpr std::size_t kIdBegin = 21, kIdBytes = 36;  // a random UUID in the header, OpenVDB's
  const Scan scan;
  std::vector<std::string> volumes;
  for (const char* threads : {"1", "2", "8"}) {
    ASSERT_EQ(scan.run({"--threads", threads, "--save-volume", (scan / "volume.vdb").string()}).exit_code, 0);
    volumes.push_back(read_text(scan / "volume.vdb"));
    ASSERT_GT(volumes.back().size(), kIdBegin + kIdBytes);
    volumes.back().erase(kIdBegin, kIdBytes);
  }
  EXPECT_TRUE(volumes[1] == volumes[0]);
  EXPECT_TRUE(volumes[2] == volumes[0]);
}

TEST(Run, TheMeshIsTheSameBytesForAnyNumberOfThreads) {
  const Scan scan;
  std::vector<std::string> glb, ply;
  for (const char* threads : {"1", "2", "8"}) {
    ASSERT_EQ(scan.run({"--threads", threads}).exit_code, 0);
    glb.push_back(read_text(scan.output() / "model.glb"));
    ply.push_back(read_text(scan.output() / "model.ply"));
  }
  EXPECT_FALSE(glb[0].empty());
  EXPECT_EQ(glb[0], glb[1]);
  EXPECT_EQ(glb[0], glb[2]);
  EXPECT_EQ(ply[0], ply[1]);
  EXPECT_EQ(ply[0], ply[2]);
}

TEST(Extract, ContinuesFromASavedVolume) {
  const Scan scan;
  const fs::path volume = scan / "v.vdb";
  ASSERT_EQ(scan.run({"--save-volume", volume.string(), "--set", "extract.min_component_triangles=0", "--set",
                      "extract.min_weight=0"})
                .exit_code,
            0);
  const Outcome outcome = scanknit_command({"extract", volume.string(), "-o", (scan / "again.ply").string()});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(read_text(scan / "again.ply"), read_text(scan.output() / "model.ply"));
}

TEST(Extract, AnIsovalueThatNothingMeetsExitsWith7AndWritesNoMesh) {
  const Scan scan;
  const fs::path volume = scan / "v.vdb";
  ASSERT_EQ(scan.run({"--save-volume", volume.string()}).exit_code, 0);
  const Outcome outcome =
      scanknit_command({"extract", volume.string(), "-o", (scan / "empty").string(), "--isovalue", "7"});
  EXPECT_EQ(outcome.exit_code, 7);
  EXPECT_FALSE(fs::exists(scan / "empty" / "model.glb"));
  const Json report = Json::parse(read_text(scan / "empty" / "report.json"), nullptr, false);
  EXPECT_EQ(report["exit_code"], 7);
}

TEST(Run, SavesAVolumeThatOpenVdbsOwnToolLists) {
  if (std::system("command -v vdb_print > /dev/null") != 0) {
    GTEST_SKIP() << "SKIPPED: vdb_print is not installed (Debian package libopenvdb-tools)";
  }
  const Scan scan;
  const std::string volume = (scan / "v.vdb").string();
  ASSERT_EQ(scan.run({"--save-volume", volume}).exit_code, 0);
  const std::string listing = (scan / "listing.txt").string();
  ASSERT_EQ(std::system(("vdb_print '" + volume + "' > '" + listing + "'").c_str()), 0);
  const std::string text = read_text(listing);
  for (const char* grid : {"tsdf", "weight", "colour"}) EXPECT_NE(text.find(grid), std::string::npos) << text;
}

TEST(Info, DescribesRecordingsVolumesAndMeshes) {
  const Scan scan;
  ASSERT_EQ(scan.run({"--save-volume", (scan / "v.vdb").string()}).exit_code, 0);
  const auto info = [](const fs::path& file) {
    return Json::parse(scanknit_command({"info", "--json", file.string()}).out, nullptr, false);
  };
  const Json recording = info(scan.recording());
  EXPECT_EQ(recording["kind"], "recording");
  EXPECT_EQ(recording["frames"], kScanFrames);
  EXPECT_EQ(recording["width"], 96);
  EXPECT_EQ(recording["has_poses"], true);
  const Json volume = info(scan / "v.vdb");
  EXPECT_EQ(volume["kind"], "volume");
  EXPECT_NEAR(volume["voxel_size_m"].get<double>(), 0.008, 1e-9);
  const Json mesh = info(scan.output() / "model.ply");
  EXPECT_EQ(mesh["kind"], "mesh");
  EXPECT_EQ(mesh["triangles"], scan.report()["mesh"]["triangles"]);
}

TEST(Distance, OfANoiselessSphereIsFarBelowAVoxel) {
  const Scan scan({.width = 320, .height = 240});  // pixels of 2 mm, a quarter of a voxel
  ASSERT_EQ(scan.run().exit_code, 0);
  const Outcome outcome =
      scanknit_command({"distance", "--json", (scan.output() / "model.ply").string(), scan.recording().string()});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json error = Json::parse(outcome.out, nullptr, false);
  constexpr double kMeanM = 0.001;  // an eighth of a voxel
  EXPECT_LT(error["area"]["mean_m"].get<double>(), kMeanM);
  EXPECT_GT(error["share_complete"].get<double>(), 0.9);
}

/// A run that takes long enough to be interrupted: fine voxels.
std::vector<std::string> slow_run(const Scan& scan) {
  return {"run", scan.recording().string(), "-o", scan.output().string(), "--set", "fusion.voxel_size=0.5mm"};
}

void wait_until_fusing(Program& program) {
  while (program.is_running() && program.err_so_far().find("fusing") == std::string::npos) {
    std::this_thread::yield();
  }
}

TEST(Interrupt, CtrlCMeshesWhatThereIsAndExitsWith130) {
  const Scan scan({.frames = 60});
  Program program(slow_run(scan));
  wait_until_fusing(program);
  program.send(SIGINT);
  const Outcome outcome = program.wait();
  EXPECT_EQ(outcome.exit_code, 130) << outcome.err;
  EXPECT_NE(outcome.err.find("interrupted"), std::string::npos);
  EXPECT_TRUE(fs::exists(scan.output() / "model.glb"));
  const Json report = scan.report();
  EXPECT_EQ(report["exit_code"], 130);
  EXPECT_LT(report["frames"]["fused"].get<int>(), 60);
  EXPECT_GT(report["frames"]["fused"].get<int>(), 0);
}

TEST(Interrupt, ASecondCtrlCLeavesAtOnce) {
  const Scan scan({.frames = 60});
  Program program(slow_run(scan));
  wait_until_fusing(program);
  while (program.is_running()) program.send(SIGINT);
  EXPECT_EQ(program.wait().exit_code, 130);
}

/// Three frames, and then it waits for Enter.
std::vector<std::string> stepped_run(const Scan& scan) {
  return {"run",   scan.recording().string(), "-o",     scan.output().string(),
          "--set", "fusion.voxel_size=8mm",   "--pace", "stepped"};
}

TEST(Interrupt, AClosedTerminalEndsTheScanWithItsMesh) {
  const Scan scan;
  Program program(stepped_run(scan));
  program.type("\n\n\n");
  wait_until_fusing(program);
  while (program.is_running()) program.send(SIGHUP);  // the shell and the kernel say it both
  const Outcome outcome = program.wait();
  EXPECT_EQ(outcome.exit_code, 130) << outcome.err;
  EXPECT_TRUE(fs::exists(scan.output() / "model.glb"));
  EXPECT_EQ(scan.report()["exit_code"], 130);
}

/// In a terminal of its own, which then goes: what it says can no more be written.
TEST(Interrupt, AScanWhoseTerminalIsGoneWritesItsMeshAllTheSame) {
  const Scan scan;
  std::vector<std::string> arguments = stepped_run(scan);
  arguments.insert(arguments.begin(), test::kProgram);
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  int terminal = -1;
  const pid_t process = ::forkpty(&terminal, nullptr, nullptr, nullptr);
  ASSERT_GE(process, 0);
  if (process == 0) {
    ::execv(test::kProgram.c_str(), argv.data());
    ::_exit(127);
  }
  ASSERT_EQ(::write(terminal, "\n", 1), 1);
  std::string said;
  std::array<char, 256> piece{};
  while (said.find("fusing 1") == std::string::npos) {
    const ssize_t bytes = ::read(terminal, piece.data(), piece.size());
    ASSERT_GT(bytes, 0) << said;
    said.append(piece.data(), static_cast<std::size_t>(bytes));
  }
  ::close(terminal);
  int status = 0;
  ASSERT_EQ(::waitpid(process, &status, 0), process);
  EXPECT_TRUE(WIFEXITED(status)) << "ended by signal " << WTERMSIG(status);
  EXPECT_EQ(WEXITSTATUS(status), 130);
  EXPECT_TRUE(fs::exists(scan.output() / "model.glb"));
}

TEST(Interrupt, NohupOutlivesTheTerminal) {
  const Scan scan;
  const auto before = ::signal(SIGHUP, SIG_IGN);
  Program program(stepped_run(scan));
  ::signal(SIGHUP, before);
  program.type("\n\n\n");
  wait_until_fusing(program);
  program.send(SIGHUP);
  program.type("\n\n");
  const Outcome outcome = program.wait();  // closes stdin, which is the end
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(scan.report()["frames"]["read"], 5);
}

}  // namespace
}  // namespace scanknit
