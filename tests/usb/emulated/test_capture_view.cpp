// capture --view: somebody looks on and presses the buttons while an emulated camera streams.
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "acquire/synthetic/surface_error.h"
#include "export/read_mesh.h"
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
