// --view and view: what somebody who looks on sees and does, and what is left of the scan afterwards.
#include <gtest/gtest.h>
#include <signal.h>

#include <array>
#include <chrono>
#include <cstring>
#include <fstream>
#include <optional>
#include <thread>
#include <utility>

#include "tests/app/program.h"
#include "tests/app/scan.h"
#include "tests/view/page_client.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using namespace std::chrono_literals;
using test::PageClient;

/// Waits for a text on stderr; false when the program ended without it.
bool wait_for(Program& program, const std::string& text) {
  while (program.err_so_far().find(text) == std::string::npos) {
    if (!program.is_running()) return program.err_so_far().find(text) != std::string::npos;
    std::this_thread::sleep_for(5ms);
  }
  return true;
}

/// The port of the link that was printed; 0: there was none.
std::uint16_t port_of(Program& program) {
  if (!wait_for(program, "live view: http://127.0.0.1:")) return 0;
  (void)wait_for(program, "/\n");
  const std::string err = program.err_so_far();
  const std::string begin = "http://127.0.0.1:";
  return static_cast<std::uint16_t>(std::stoi(err.substr(err.find(begin) + begin.size())));
}

std::vector<std::string> run_with_view(const Scan& scan, const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments = {"run",   scan.recording().string(), "-o",     scan.output().string(),
                                        "--set", "fusion.voxel_size=8mm",   "--view", "--port",
                                        "0"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

class ViewTest : public testing::Test {
 protected:
  void SetUp() override {
    const TempFolder folder;
    const Outcome outcome = scanknit_command({"view", (folder / "absent.glb").string()});
    if (outcome.err.find("without the live view") != std::string::npos)
      GTEST_SKIP() << "SKIPPED: built without the page (npm ci --prefix view/page)";
  }

  /// A scan of five seconds at the scanner's pace, or by steps, and somebody who looks on from the beginning.
  void watch(const std::vector<std::string>& more = {}, const char* pace = "realtime") {
    scan.emplace(ScanSize{.frames = 150});
    std::vector<std::string> arguments = run_with_view(*scan, more);
    arguments.insert(arguments.end(), {"--pace", pace});
    program.emplace(arguments);
    port = port_of(*program);
    ASSERT_NE(port, 0) << program->err_so_far();
    client = PageClient::connect(port);
    ASSERT_NE(client, nullptr);
    ASSERT_EQ(client->next_of("hello")["mode"], "run");
  }

  /// "" when it was done.
  std::string ask(const std::string& command, const std::string& more = "") {
    client->say(R"({"cmd":")" + command + R"(","id":)" + std::to_string(++id) + more + "}");
    for (auto answer = client->next_of("ack"); !answer.is_null(); answer = client->next_of("ack")) {
      if (answer["id"] == id) return answer["error"];
    }
    return "no answer";
  }

  Json state_in_phase(const std::string& phase) {
    for (auto state = client->next_of("state"); !state.is_null(); state = client->next_of("state")) {
      if (state["phase"] == phase) return state;
    }
    return nullptr;
  }

  Json report_at_the_end() {
    EXPECT_TRUE(wait_for(*program, "stays open until Ctrl-C")) << program->err_so_far();
    program->send(SIGINT);
    const Outcome outcome = program->wait();
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return scan->report();
  }

  std::optional<Scan> scan;
  std::optional<Program> program;
  std::unique_ptr<PageClient> client;
  std::uint16_t port = 0;
  int id = 0;
};

TEST_F(ViewTest, TheMeshIsTheSameAsWithoutIt) {
  const Scan plain;
  const Outcome outcome = plain.run();
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const std::string expected = read_text(plain.output() / "model.ply");

  Program watched(run_with_view(plain));
  ASSERT_TRUE(wait_for(watched, "stays open until Ctrl-C")) << watched.err_so_far();
  watched.send(SIGINT);
  EXPECT_EQ(watched.wait().exit_code, 0);
  EXPECT_EQ(read_text(plain.output() / "model.ply"), expected);
  EXPECT_TRUE(fs::exists(plain.output() / "model.stl"));
  EXPECT_TRUE(plain.report()["stages"].contains("view"));
}

TEST_F(ViewTest, PausedFramesAreLeftOutAndCounted) {
  watch();
  ASSERT_EQ(ask("pause"), "");
  for (Json state = state_in_phase("paused"); state["dropped"].get<int>() == 0; state = state_in_phase("paused")) {
    ASSERT_FALSE(state.is_null());
  }
  ASSERT_EQ(ask("start"), "");
  const Json frames = report_at_the_end()["frames"];
  EXPECT_GT(frames["dropped_by_reason"]["paused"], 0);
  EXPECT_EQ(frames["read"], frames["fused"].get<int>() + frames["dropped"].get<int>());
  EXPECT_GT(frames["fused"], 0);
}

TEST_F(ViewTest, CommandsAreAnsweredBeforeTheFirstFrame) {
  watch({}, "stepped");
  const auto crop = [&] { return ask("crop", R"(,"box":[[-1,-1,0.02],[1,1,1]])"); };
  std::string answer = crop();
  for (int tries = 0; tries < 200 && answer.find("has not begun") != std::string::npos; ++tries) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));  // the page is served a moment before the scan begins
    answer = crop();
  }
  ASSERT_EQ(answer, "");
  EXPECT_EQ(ask("export"), "nothing has been fused yet");
  EXPECT_EQ(ask("pause"), "");
  EXPECT_EQ(ask("start"), "");
  EXPECT_FALSE(state_in_phase("waiting").is_null()) << "nothing has been seen";
  EXPECT_EQ(ask("reset"), "");
  EXPECT_EQ(ask("finish"), "");
  const Outcome outcome = program->wait();
  EXPECT_EQ(outcome.exit_code, 4) << outcome.err;
  EXPECT_NE(outcome.err.find("finished before the first frame"), std::string::npos) << outcome.err;
}

TEST_F(ViewTest, CommandsAreAnsweredWhileNoOtherFrameComes) {
  watch({}, "stepped");
  program->type("\n\n");
  while (client->next_of("state")["fused"].get<int>() < 2) {
  }
  EXPECT_EQ(ask("export"), "");
  EXPECT_EQ(ask("finish"), "");
  EXPECT_FALSE(state_in_phase("finished").is_null());
  EXPECT_EQ(report_at_the_end()["frames"]["read"], 2);
}

TEST_F(ViewTest, ReportsDroppedFramesAtOnce) {
  scan.emplace(ScanSize{.frames = 6});
  for (std::size_t place = 0; place < 3; ++place) std::ofstream(scan->depth_picture(place)) << "no picture";
  program.emplace(run_with_view(*scan, {"--pace", "stepped"}));
  port = port_of(*program);
  ASSERT_NE(port, 0) << program->err_so_far();
  client = PageClient::connect(port);
  ASSERT_NE(client, nullptr);
  program->type("\n\n");
  Json state = client->next_of("state");
  while (!state.is_null() && state["dropped"] != 2) state = client->next_of("state");
  ASSERT_FALSE(state.is_null()) << "nobody said that two frames were dropped";
  EXPECT_EQ(state["phase"], "waiting");
  EXPECT_EQ(state["frame"], 2);
}

TEST_F(ViewTest, ExportWritesTheMeshOfNow) {
  watch();
  while (client->next_of("state")["fused"].get<int>() == 0) {
  }
  ASSERT_EQ(ask("pause"), "");
  ASSERT_EQ(ask("export"), "");
  EXPECT_EQ(test::http_request(port, "GET", "/files/model.glb").body.substr(0, 4), "glTF");
  EXPECT_GT(test::http_request(port, "GET", "/files/model.stl").body.size(), 84u);
  EXPECT_EQ(test::http_request(port, "GET", "/files/report.json").status, 404);
  ASSERT_EQ(ask("start"), "");
  EXPECT_EQ(report_at_the_end()["exit_code"], 0);
}

TEST_F(ViewTest, ResetBeginsAnew) {
  watch();
  while (client->next_of("state")["fused"].get<int>() < 5) {
  }
  ASSERT_EQ(ask("reset"), "");
  const Json report = report_at_the_end();
  const Json frames = report["frames"];
  EXPECT_GE(frames["dropped_by_reason"]["reset"], 5);
  EXPECT_EQ(frames["read"], frames["fused"].get<int>() + frames["dropped"].get<int>());
  EXPECT_NE(report["warnings"].dump().find("started over"), std::string::npos);
  EXPECT_GT(report["mesh"]["triangles"], 0);
}

TEST_F(ViewTest, FinishEndsTheScanWithItsMesh) {
  watch();
  while (client->next_of("state")["fused"].get<int>() == 0) {
  }
  ASSERT_EQ(ask("finish"), "");
  EXPECT_FALSE(state_in_phase("finished").is_null());
  EXPECT_EQ(ask("start"), "the scan is over");
  const Json report = report_at_the_end();
  EXPECT_LT(report["frames"]["read"], 150);
  EXPECT_EQ(report["status"], "ok");
}

TEST_F(ViewTest, AResetAfterFinishIsRefused) {
  watch();
  while (client->next_of("state")["fused"].get<int>() == 0) {
  }
  client->say(R"({"cmd":"finish","id":1})");
  client->say(R"({"cmd":"reset","id":2})");
  for (auto answer = client->next_of("ack"); answer["id"] != 2; answer = client->next_of("ack")) {
    ASSERT_FALSE(answer.is_null());
  }
  EXPECT_GT(report_at_the_end()["frames"]["fused"], 0);
}

TEST_F(ViewTest, ACropBoxThatHoldsNothingIsNamedAndCanBeCleared) {
  watch();
  while (client->next_of("state")["fused"].get<int>() == 0) {
  }
  ASSERT_EQ(ask("crop", R"(,"box":[[100,100,100],[101,101,101]])"), "");
  EXPECT_NE(ask("export").find("crop box"), std::string::npos);
  ASSERT_EQ(ask("crop", R"(,"box":null)"), "");
  EXPECT_EQ(ask("export"), "");
  EXPECT_EQ(report_at_the_end()["exit_code"], 0);
}

TEST_F(ViewTest, FinishUnderACropBoxThatHoldsNothingWritesTheWholeMesh) {
  watch();
  while (client->next_of("state")["triangles"].get<int>() == 0) {
  }
  ASSERT_EQ(ask("crop", R"(,"box":[[100,100,100],[101,101,101]])"), "");
  Json told = client->next_of("state");
  while (!told.is_null() && !told["is_crop_empty"].get<bool>()) told = client->next_of("state");
  ASSERT_FALSE(told.is_null()) << "nobody said so beforehand";
  ASSERT_EQ(ask("finish"), "");
  EXPECT_NE(state_in_phase("finished")["message"].get<std::string>().find("crop box"), std::string::npos);
  const Json report = report_at_the_end();
  EXPECT_GT(report["mesh"]["triangles"], 0);
  EXPECT_NE(report["warnings"].dump().find("whole mesh"), std::string::npos) << report["warnings"];
}

TEST_F(ViewTest, NothingIsMeshedOutsideTheCropBox) {
  watch();
  ASSERT_EQ(ask("crop", R"(,"box":[[-1,-1,0.02],[1,1,1]])"), "");  // the sphere's middle is the origin
  const Json bounds = report_at_the_end()["mesh"]["bounds_m"];
  EXPECT_GE(bounds[0][2].get<double>(), 0.02 - 1e-6);
  EXPECT_LT(bounds[0][0].get<double>(), -0.09);
}

/// A thing that hardly turns: what stands still is learnt and cut away, and in vain, for this is no turntable. Then the
/// frames are meshed as they are.
class ViewOfNoTurntable : public ViewTest {
 protected:
  void watch_at(const char* pace) {
    const Outcome synth =
        scanknit_command({"synth", "tower", "--turntable", "--turns", "0.06", "-o", folder_ / "recording", "--frames",
                          "60", "--width", "240", "--height", "180", "--quiet"});
    ASSERT_EQ(synth.exit_code, 0) << synth.err;
    program.emplace(std::vector<std::string>{"run", folder_ / "recording", "-o", folder_ / "out", "--preset",
                                             "turntable", "--set", "fusion.voxel_size=2mm", "--view", "--port", "0",
                                             "--pace", pace});
    port = port_of(*program);
    ASSERT_NE(port, 0) << program->err_so_far();
    client = PageClient::connect(port);
    ASSERT_NE(client, nullptr);
  }
  void watch_steps(int steps) {
    ASSERT_NO_FATAL_FAILURE(watch_at("stepped"));
    program->type(std::string(static_cast<std::size_t>(steps), '\n'));
    until_frame(steps);
  }
  void until_frame(int frame) {
    Json state = client->next_of("state");
    while (!state.is_null() && state["frame"].get<int>() < frame) state = client->next_of("state");
    ASSERT_FALSE(state.is_null());
  }
  Json report_of_finished() {
    EXPECT_EQ(ask("finish"), "");
    EXPECT_FALSE(state_in_phase("finished").is_null());
    program->send(SIGINT);
    const Outcome outcome = program->wait();
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    const Json report = Json::parse(read_text(folder_ / "out" / "report.json"));
    EXPECT_EQ(report["turntable"]["is_refined"], false) << "not what this test is about";
    EXPECT_FALSE(report["turntable"]["reason"].get<std::string>().empty());
    return report;
  }

  TempFolder folder_;
};

TEST_F(ViewOfNoTurntable, ACommandPausesTheScan) {
  ASSERT_NO_FATAL_FAILURE(watch_at("realtime"));
  ASSERT_NO_FATAL_FAILURE(until_frame(10));
  ASSERT_EQ(ask("pause"), "");
  const int skipped = state_in_phase("paused")["dropped"];
  for (Json state = state_in_phase("paused"); state["dropped"].get<int>() < skipped + 5;
       state = state_in_phase("paused")) {
    ASSERT_FALSE(state.is_null());
  }
  ASSERT_EQ(ask("start"), "");
  const Json report = report_of_finished();
  const Json frames = report["frames"];
  const int paused = frames["dropped_by_reason"]["paused"];
  EXPECT_GE(paused, 5);
  EXPECT_EQ(frames["dropped"], paused);
  EXPECT_EQ(frames["fused"].get<int>() + frames["lost"].get<int>() + paused, frames["read"]);
  EXPECT_EQ(report["tracking"]["frames"].size() + static_cast<std::size_t>(paused), frames["read"]);
}

TEST_F(ViewOfNoTurntable, ACommandFinishesTheScan) {
  ASSERT_NO_FATAL_FAILURE(watch_steps(20));
  const Json frames = report_of_finished()["frames"];
  EXPECT_EQ(frames["read"], 20);
  EXPECT_EQ(frames["fused"], 20);
}

TEST_F(ViewOfNoTurntable, ACommandResetsTheScan) {
  ASSERT_NO_FATAL_FAILURE(watch_steps(10));
  ASSERT_EQ(ask("reset"), "");
  program->type(std::string(10, '\n'));
  ASSERT_NO_FATAL_FAILURE(until_frame(20));
  const Json report = report_of_finished();
  EXPECT_EQ(report["frames"]["read"], 20);
  EXPECT_EQ(report["frames"]["fused"], 10);
  EXPECT_EQ(report["frames"]["dropped_by_reason"]["reset"], 10);
  EXPECT_EQ(report["tracking"]["frames"].at(0)["frame"], 10);
}

TEST_F(ViewOfNoTurntable, ACommandSetsTheCropBox) {
  ASSERT_NO_FATAL_FAILURE(watch_steps(20));
  ASSERT_EQ(ask("crop", R"(,"box":[[-0.1,-0.1,0.1],[0.1,0.1,2]])"), "");
  const Json bounds = report_of_finished()["mesh"]["bounds_m"];
  EXPECT_GE(bounds[0][0].get<double>(), -0.1 - 1e-6);
  EXPECT_LE(bounds[1][0].get<double>(), 0.1 + 1e-6);
}

TEST_F(ViewTest, AFinishedMeshIsShown) {
  const Scan plain;
  ASSERT_EQ(plain.run().exit_code, 0);
  for (const char* name : {"", "model.ply", "model.glb"}) {
    Program shown({"view", (plain.output() / name).string(), "--port", "0"});
    const std::uint16_t there = port_of(shown);
    ASSERT_NE(there, 0) << shown.err_so_far();
    const auto visitor = PageClient::connect(there);
    ASSERT_NE(visitor, nullptr);
    EXPECT_TRUE(visitor->next_of("hello")["commands"].empty());
    EXPECT_EQ(visitor->next_of("state")["triangles"], plain.report()["mesh"]["triangles"]);
    EXPECT_FALSE(visitor->next_binaries(/*gives_credit=*/true).empty());
    shown.send(SIGINT);
    EXPECT_EQ(shown.wait().exit_code, 0);
  }
}

TEST_F(ViewTest, AFinishedMeshIsShownWithItsVoxelSizeAndUncertainty) {
  const Scan plain;
  ASSERT_EQ(plain.run({"--set", "export.uncertainty=true"}).exit_code, 0);
  fs::copy(plain.output() / "model.ply", plain.output() / "other.ply");
  for (const auto& [name, voxel_size_m] : {std::pair{"model.ply", 0.008}, std::pair{"other.ply", 0.0}}) {
    Program shown({"view", (plain.output() / name).string(), "--port", "0"});
    const std::uint16_t there = port_of(shown);
    const auto visitor = there == 0 ? nullptr : PageClient::connect(there);
    ASSERT_NE(visitor, nullptr);
    EXPECT_DOUBLE_EQ(visitor->next_of("hello")["voxel_size_m"].get<double>(), voxel_size_m)
        << "as the report beside it says";
    std::size_t stated = 0, vertices = 0;
    for (const std::string& chunk : visitor->next_binaries(/*gives_credit=*/true)) {
      constexpr std::size_t kVertices = 16, kFirst = 48, kVertexBytes = 16, kUncertainty = 6;  // live_view.md
      std::uint32_t count = 0;
      std::memcpy(&count, chunk.data() + kVertices, sizeof(count));
      for (std::size_t v = 0; v < count; ++v, ++vertices) {
        std::uint16_t micrometres = 0;
        std::memcpy(&micrometres, chunk.data() + kFirst + kVertexBytes * v + kUncertainty, sizeof(micrometres));
        stated += micrometres > 0 ? 1 : 0;
      }
    }
    EXPECT_GT(stated, vertices / 2);
    shown.send(SIGINT);
    EXPECT_EQ(shown.wait().exit_code, 0);
  }
}

/// The mean of what the page is sent for a file, red, green, blue; nothing where a chunk has no colours.
std::optional<std::array<double, 3>> mean_colour_shown(const std::string& file) {
  Program shown({"view", file, "--port", "0"});
  const std::uint16_t there = port_of(shown);
  const auto visitor = there == 0 ? nullptr : PageClient::connect(there);
  if (visitor == nullptr) return std::nullopt;
  std::array<double, 3> sum{};
  std::size_t count = 0;
  bool all_have_colours = true;
  for (const std::string& chunk : visitor->next_binaries(/*gives_credit=*/true)) {
    constexpr std::size_t kVertices = 16, kFlags = 24, kFirst = 48, kVertexBytes = 16, kColour = 8;  // live_view.md
    std::uint32_t vertices = 0, flags = 0;
    std::memcpy(&vertices, chunk.data() + kVertices, sizeof(vertices));
    std::memcpy(&flags, chunk.data() + kFlags, sizeof(flags));
    all_have_colours = all_have_colours && (flags & 1) != 0;
    for (std::size_t v = 0; v < vertices; ++v, ++count) {
      for (std::size_t k = 0; k < 3; ++k) {
        sum[k] += static_cast<unsigned char>(chunk.at(kFirst + kVertexBytes * v + kColour + k));
      }
    }
  }
  shown.send(SIGINT);
  EXPECT_EQ(shown.wait().exit_code, 0);
  if (count == 0 || !all_have_colours) return std::nullopt;
  for (double& channel : sum) channel /= static_cast<double>(count);
  return sum;
}

TEST_F(ViewTest, ATexturedMeshIsShownInItsColours) {
  const Scan recorded;
  ASSERT_EQ(recorded.run({"--texture"}).exit_code, 0);
  const auto plain = mean_colour_shown((recorded.output() / "model.ply").string());
  const auto textured = mean_colour_shown((recorded.output() / "model.glb").string());
  ASSERT_TRUE(plain && textured);
  constexpr double kFiner = 8;  // of 255: a texel is no mean over voxels, and vertices are doubled at seams
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR((*textured)[k], (*plain)[k], kFiner) << k;
}

TEST_F(ViewTest, WhatIsNoMeshIsSaidToBeNone) {
  const TempFolder folder;
  std::ofstream(folder / "text.glb") << "this is no mesh";
  EXPECT_EQ(scanknit_command({"view", (folder / "text.glb").string()}).exit_code, 4);
  EXPECT_EQ(scanknit_command({"view", (folder / "absent.ply").string()}).exit_code, 4);
  for (const char* name : {"absent.ply", "absent"}) {
    EXPECT_NE(scanknit_command({"view", (folder / name).string()}).err.find("no such file or folder"),
              std::string::npos)
        << name;
  }
  const Outcome empty_folder = scanknit_command({"view", folder.path().string()});
  EXPECT_EQ(empty_folder.exit_code, 4);
  EXPECT_NE(empty_folder.err.find("--view"), std::string::npos) << "what to do for a recording";
}

TEST_F(ViewTest, OptionsThatCannotBeAreRefusedBeforeAnyWork) {
  const Scan plain;
  EXPECT_EQ(plain.run({"--port", "0"}).exit_code, 2);  // without --view
  EXPECT_EQ(plain.run({"--view", "--listen", "example.org"}).exit_code, 2);
  EXPECT_EQ(plain.run({"--view", "--port", "70000"}).exit_code, 2);
  EXPECT_EQ(plain.run({"--view", "--port", "0", "--listen", "203.0.113.1"}).exit_code, 8);  // of no computer
  EXPECT_FALSE(fs::exists(plain.output())) << "not even an empty folder";
}

}  // namespace
}  // namespace scanknit
