// capture --view: somebody looks on and presses the buttons while an emulated camera streams.
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <thread>
#include <utility>
#include <vector>

#include "export/mesh/read_mesh.h"
#include "synth/scene/scene.h"
#include "synth/surface_error.h"
#include "synth/synthetic_source.h"
#include "tests/app/program.h"
#include "tests/usb/emulated/desk_view.h"
#include "tests/usb/emulated/emulated_bus.h"
#include "tests/view/page_client.h"

namespace scanknit::test {
namespace {

using nlohmann::json;
using namespace std::chrono_literals;

constexpr double kVoxel_m = 0.008;

/// The port of the link that the program printed; 0: it ended without one.
std::uint16_t port_of(Program& program) {
  const std::string begin = "live view: http://127.0.0.1:";
  while (true) {
    const std::string err = program.err_so_far();
    const std::size_t at = err.find(begin);
    if (at != std::string::npos && err.find('\n', at) != std::string::npos)
      return static_cast<std::uint16_t>(std::stoi(err.substr(at + begin.size())));
    if (!program.is_running()) return 0;
    std::this_thread::sleep_for(10ms);
  }
}

std::uint32_t number_at(const std::string& message, std::size_t at) {
  std::uint32_t number = 0;
  std::memcpy(&number, message.data() + at, sizeof(number));
  return number;
}

/// The first state that fits; null when the connection ends before.
template <typename Fits>
json state_that(PageClient& client, const Fits& fits) {
  json state = client.next_of("state");
  while (!state.is_null() && !fits(state)) state = client.next_of("state");
  return state;
}

TEST(CaptureView, PausesGoesOnAndFinishesWithTheMesh) {
  (void)slow_desk_view();
  EmulatedBus bus;
  const int address = bus.plug(camera_at(slow_desk_view()));
  const TempFolder folder;
  Program program({"capture", "-o", (folder / "out").string(), "--fps", "15", "--set", "fusion.voxel_size=8mm",
                   "--view", "--port", "0"});
  bus.serve(address, program.process());
  const std::uint16_t port = port_of(program);
  ASSERT_NE(port, 0) << program.err_so_far();
  const auto client = PageClient::connect(port);
  ASSERT_NE(client, nullptr);
  EXPECT_EQ(client->next_of("hello")["mode"], "capture");

  ASSERT_FALSE(state_that(*client, [](const json& state) { return state["fused"] >= 3; }).is_null());
  client->say(R"({"cmd":"pause","id":1})");
  const json paused = state_that(*client, [](const json& state) { return state["phase"] == "paused"; });
  ASSERT_FALSE(paused.is_null());
  const auto passes_by = [&](const json& state) { return state["dropped"] > paused["dropped"]; };
  ASSERT_FALSE(state_that(*client, passes_by).is_null()) << "the camera's pictures pile up";
  const auto late = PageClient::connect(port);
  ASSERT_NE(late, nullptr);
  const auto has_picture = [&](const json&) {
    late->say(R"({"got":)" + std::to_string(late->binaries.size()) + "}");
    const std::vector<std::string> messages = std::exchange(late->binaries, {});
    return std::any_of(messages.begin(), messages.end(),
                       [](const std::string& message) { return number_at(message, 4) == 3; });
  };
  ASSERT_FALSE(state_that(*late, has_picture).is_null()) << "nothing to be seen for who comes in a pause";
  client->say(R"({"cmd":"start","id":2})");
  const auto goes_on = [&](const json& state) { return state["fused"] > paused["fused"]; };
  ASSERT_FALSE(state_that(*client, goes_on).is_null());
  client->say(R"({"cmd":"finish","id":3})");
  ASSERT_FALSE(state_that(*client, [](const json& state) { return state["phase"] == "finished"; }).is_null());
  EXPECT_EQ(http_request(port, "GET", "/files/model.glb").body.substr(0, 4), "glTF");
  program.send(SIGINT);
  const Outcome outcome = program.wait();
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;

  const json report = json::parse(read_text(folder / "out/report.json"));
  EXPECT_GT(report["frames"]["dropped_by_reason"]["paused"], 0);
  EXPECT_EQ(report["frames"]["lost"], 0);
  auto mesh = read_mesh(folder / "out/model.ply");
  ASSERT_TRUE(mesh) << mesh.error().text();
  const std::uint64_t first = report["tracking"]["frames"][0]["frame"];
  const Eigen::Isometry3f T_world_mesh = slow_desk_view().pose(first).cast<float>();
  for (Eigen::Vector3f& p : mesh->positions_m) p = T_world_mesh * p;
  const auto error = measure_surface(*mesh, slow_desk_view().scene(), {});
  ASSERT_TRUE(error);
  EXPECT_LT(error->vertices.mean_m, kVoxel_m / 4);
}

/// A camera before a turntable with a ball at first, then a tower. All pictures are there before the camera's clock
/// runs.
class Turning {
 public:
  static constexpr int kTurn = 48;  // pictures
  static constexpr double kFocal = 262.5;

  Turning() {
    config_.frames = kTurn;
    config_.intrinsics = {320, 240, kFocal, kFocal, 159.5, 119.5};
    config_.turntable = RigConfig{};
    ball_ = pictures_of("sphere", 1).front();
    tower_ = pictures_of("tower", kTurn);
  }

  VcamOptions camera() {
    VcamOptions options;
    options.has_colour = false;
    options.width = config_.intrinsics.width;
    options.height = config_.intrinsics.height;
    options.depth_picture = [this](std::uint64_t n) { return next(n); };
    return options;
  }

  void show_ball() { is_ball_ = true; }
  void show_tower() { is_ball_ = false; }
  /// It stands still from there on.
  void turn_until(std::size_t picture) { until_ = picture; }
  [[nodiscard]] bool stands() const { return at_ == until_; }

  /// Pictures.
  [[nodiscard]] std::uint64_t sent() const { return sent_; }
  /// By their numbers; not while the camera streams.
  [[nodiscard]] const std::set<std::uint64_t>& pictures_of_ball() const { return of_ball_; }

 private:
  std::vector<std::vector<std::byte>> pictures_of(const char* name, int count) {
    const auto scene = make_scene(name).value();
    const SyntheticScanner scanner(*scene, config_);
    std::vector<std::vector<std::byte>> pictures;
    for (int n = 0; n < count; ++n) pictures.push_back(depth_bytes(scanner.shoot(static_cast<std::size_t>(n)).depth_m));
    return pictures;
  }
  /// On the camera's thread.
  std::vector<std::byte> next(std::uint64_t number) {
    sent_ = number + 1;
    if (is_ball_) {
      of_ball_.insert(number);
      return ball_;
    }
    if (at_ < until_) ++at_;
    return tower_[at_];
  }

  SynthConfig config_;
  std::vector<std::byte> ball_;
  std::vector<std::vector<std::byte>> tower_;
  std::atomic<bool> is_ball_ = true;
  std::atomic<std::size_t> at_ = 0, until_ = 0;
  std::atomic<std::uint64_t> sent_ = 0;
  std::set<std::uint64_t> of_ball_;
};

/// What came before Reset, and what passed by in a pause, is in the recording and yet not in what is made of it.
TEST(CaptureView, ARefinedTurntableIsOfTheFramesThatWereWanted) {
  Turning turning;
  EmulatedBus bus;
  const int address = bus.plug(turning.camera());
  const TempFolder folder;
  const std::string focal = std::to_string(Turning::kFocal);
  Program program({"capture", "-o", (folder / "out").string(), "--fps", "15", "--preset", "turntable", "--set",
                   "fusion.voxel_size=4mm", "--set", "acquire.intrinsics=[" + focal + "," + focal + ",159.5,119.5]",
                   "--view", "--port", "0"});
  bus.serve(address, program.process());
  const std::uint16_t port = port_of(program);
  ASSERT_NE(port, 0) << program.err_so_far();
  const auto client = PageClient::connect(port);
  ASSERT_NE(client, nullptr);
  std::uint32_t newest = 0;  // revision
  const auto wait_for = [&](const auto& fits) {
    const json state = state_that(*client, fits);
    for (const std::string& message : client->binaries) newest = std::max(newest, number_at(message, 12));
    client->say(R"({"got":)" + std::to_string(client->binaries.size()) + "}");
    client->binaries.clear();
    return !state.is_null();
  };
  const auto ask = [&](const std::string& command, int id, const std::string& more = "") {
    client->say(R"({"cmd":")" + command + R"(","id":)" + std::to_string(id) + more + "}");
    return client->next_of("ack").value("error", "no answer");
  };
  // What the camera sees now has come.
  const auto is_seen = [&] {
    const std::uint64_t sent = turning.sent();
    return wait_for([&](const json& state) { return state["frame"] > sent + 1; });
  };
  const auto turn_until = [&](std::size_t picture) {
    turning.turn_until(picture);
    return wait_for([&](const json&) { return turning.stands(); }) && is_seen();
  };

  ASSERT_TRUE(wait_for([](const json& state) { return state["fused"] >= 3; })) << program.err_so_far();
  turning.show_tower();
  ASSERT_TRUE(is_seen());
  ASSERT_EQ(ask("reset", 1), "");
  ASSERT_TRUE(turn_until(Turning::kTurn / 2)) << program.err_so_far();
  ASSERT_EQ(ask("pause", 2), "");
  turning.show_ball();
  ASSERT_TRUE(is_seen());
  turning.show_tower();
  ASSERT_TRUE(is_seen());
  ASSERT_EQ(ask("start", 3), "");
  ASSERT_TRUE(turn_until(Turning::kTurn - 1)) << program.err_so_far();
  ASSERT_EQ(ask("crop", 4, R"(,"box":[[-1,-1,-1],[1,1,3]])"), "");
  ASSERT_EQ(ask("finish", 5), "");
  EXPECT_NE(ask("reset", 6).find("the scan"), std::string::npos) << "its frames are over";
  while (program.err_so_far().find("stays open until Ctrl-C") == std::string::npos) {
    ASSERT_TRUE(program.is_running()) << program.err_so_far();
    std::this_thread::sleep_for(10ms);
  }

  // Somebody who comes now has the refined mesh only.
  const auto late = PageClient::connect(port);
  ASSERT_NE(late, nullptr);
  const json end = json::parse(http_request(port, "GET", "/api/v1/state").body);
  EXPECT_EQ(end["phase"], "finished");
  EXPECT_TRUE(late->next_of("crop").at("box").is_null());
  EXPECT_EQ(late->next_of("trail").at("points").size(), end["fused"].get<std::size_t>());
  std::size_t indices = 0;
  for (const std::string& message : late->next_binaries(/*gives_credit=*/true)) {
    if (number_at(message, 4) != 1) continue;
    EXPECT_GT(number_at(message, 12), newest) << "revisions keep growing";
    indices += number_at(message, 20);
  }
  EXPECT_EQ(indices / 3, end["triangles"]);
  program.send(SIGINT);
  const Outcome outcome = program.wait();
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;

  const json report = json::parse(read_text(folder / "out/report.json"));
  EXPECT_EQ(report["turntable"]["is_refined"], true) << report["turntable"]["reason"] << outcome.err;
  EXPECT_NEAR(report["turntable"]["turns"].get<double>(), (Turning::kTurn - 1.0) / Turning::kTurn, 0.05);
  EXPECT_EQ(report["mesh"]["is_closed"], true);
  EXPECT_EQ(report["mesh"]["components"], 1);
  EXPECT_NE(report["warnings"].dump().find("crop box"), std::string::npos) << "it has gone";
  const json& frames = report["frames"];
  EXPECT_GE(frames["dropped_by_reason"]["paused"], 2);
  EXPECT_GE(frames["dropped_by_reason"]["reset"], 3);
  EXPECT_EQ(frames["read"], frames["fused"].get<int>() + frames["dropped"].get<int>() + frames["lost"].get<int>());
  EXPECT_GE(turning.pictures_of_ball().size(), 5u);
  for (const json& frame : report["tracking"]["frames"]) {
    EXPECT_FALSE(turning.pictures_of_ball().contains(frame["frame"])) << frame;
  }
}

TEST(CaptureView, TellsOfLostPicturesAndOfSilenceAndFinishesMeanwhile) {
  (void)slow_desk_view();
  EmulatedBus bus;
  const int address = bus.plug(camera_at(slow_desk_view()));
  bus.with_camera(address, [](Vcam& camera) {
    camera.depth_faults[2] = Fault::kTruncated;
    camera.lasting_fault = {Fault::kSilentForever, 20};
  });
  const TempFolder folder;
  Program program({"capture", "-o", (folder / "out").string(), "--fps", "15", "--set", "fusion.voxel_size=8mm",
                   "--view", "--port", "0"});
  bus.serve(address, program.process());
  const std::uint16_t port = port_of(program);
  ASSERT_NE(port, 0) << program.err_so_far();
  const auto client = PageClient::connect(port);
  ASSERT_NE(client, nullptr);
  const auto has_lost = [](const json& state) { return state["losses"].value("transport", 0) > 0; };
  ASSERT_FALSE(state_that(*client, has_lost).is_null()) << program.err_so_far();
  const auto is_silent = [](const json& state) { return state["silent_s"] >= 2; };
  ASSERT_FALSE(state_that(*client, is_silent).is_null()) << program.err_so_far();
  client->say(R"({"cmd":"finish","id":1})");
  EXPECT_EQ(client->next_of("ack")["ok"], true);
  ASSERT_FALSE(state_that(*client, [](const json& state) { return state["phase"] == "finished"; }).is_null());
  program.send(SIGINT);
  const Outcome outcome = program.wait();
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(read_mesh(folder / "out/model.ply"));
}

TEST(CaptureView, IsThereWhileTheScannerIsNotYet) {
  EmulatedBus bus;
  const TempFolder folder;
  Program program({"capture", "-o", (folder / "out").string(), "--wait", "600", "--view", "--port", "0"});
  const std::uint16_t port = port_of(program);
  ASSERT_NE(port, 0) << program.err_so_far();
  const auto client = PageClient::connect(port);
  ASSERT_NE(client, nullptr);
  EXPECT_EQ(client->next_of("state")["phase"], "waiting");
  client->say(R"({"cmd":"finish","id":1})");
  EXPECT_NE(client->next_of("ack")["error"].get<std::string>().find("not ready"), std::string::npos);
  program.send(SIGINT);
  EXPECT_EQ(program.wait().exit_code, 5);
}

TEST(CaptureView, WithoutAScannerDoesNotStayOpen) {
  EmulatedBus bus;
  const TempFolder folder;
  Program program({"capture", "-o", (folder / "out").string(), "--view", "--port", "0"});
  EXPECT_EQ(program.wait().exit_code, 5);
}

}  // namespace
}  // namespace scanknit::test
