// From an emulated camera that looks at a synthetic scene to the mesh, through the command line.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "acquire/frame_source.h"
#include "acquire/synthetic/surface_error.h"
#include "acquire/synthetic/synthetic_source.h"
#include "app/cli.h"
#include "export/read_mesh.h"
#include "tests/app/program.h"
#include "tests/usb/emulated/emulated_bus.h"

namespace scanknit::test {
namespace {

using nlohmann::json;

constexpr int kPictures = 45;        // three seconds of
constexpr const char* kRate = "15";  // pictures a second
constexpr double kQuarterVoxel_m = 0.002;

/// Part of a slow walk round the desk, as the emulated camera's optics would see it.
class DeskView {
 public:
  DeskView() : scene_(make_scene("desk").value()), scanner_(*scene_, config()) {
    for (int n = 0; n < kPictures; ++n) pictures_.push_back(raw(scanner_.shoot(static_cast<std::size_t>(n)).depth_m));
  }

  [[nodiscard]] const SyntheticScene& scene() const { return *scene_; }
  [[nodiscard]] Pose pose(std::size_t n) const { return scanner_.shoot(n).T_world_camera; }
  [[nodiscard]] std::vector<std::byte> picture(std::uint64_t n) const {
    return pictures_[std::min<std::size_t>(n, pictures_.size() - 1)];
  }

 private:
  static SynthConfig config() {
    SynthConfig config;
    config.frames = 600;
    config.intrinsics = {640, 480, 380, 381, 319, 241};  // realsense_bytes.h
    return config;
  }
  static std::vector<std::byte> raw(const DepthImage& depth_m) {
    std::vector<std::byte> bytes(2 * depth_m.size());
    for (std::size_t i = 0; i < depth_m.size(); ++i) {
      const auto millimetres = static_cast<std::uint16_t>(std::lround(1000 * depth_m.pixels()[i]));
      std::memcpy(bytes.data() + 2 * i, &millimetres, 2);
    }
    return bytes;
  }

  std::unique_ptr<SyntheticScene> scene_;
  SyntheticScanner scanner_;
  std::vector<std::vector<std::byte>> pictures_;
};

const DeskView& desk_view() {
  static const DeskView view;
  return view;
}

VcamOptions camera_at_the_desk() {
  VcamOptions options;
  options.has_colour = false;
  options.depth_picture = [](std::uint64_t n) { return desk_view().picture(n); };
  return options;
}

int scanknit(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "scanknit");
  std::vector<const char*> argv;
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  return run_cli(static_cast<int>(argv.size()), argv.data());
}

/// Mean distance of the mesh's vertices from the scene. A tracked mesh is in the frame of the first camera.
double mean_error_m(const std::filesystem::path& file, std::uint64_t first_picture) {
  auto mesh = read_mesh(file);
  EXPECT_TRUE(mesh);
  if (!mesh) return 1;
  const Eigen::Isometry3f T_world_mesh = desk_view().pose(first_picture).cast<float>();
  for (Eigen::Vector3f& p : mesh->positions_m) p = T_world_mesh * p;
  const auto error = measure_surface(*mesh, desk_view().scene(), {});
  EXPECT_TRUE(error);
  return error ? error->vertices.mean_m : 1;
}

TEST(CaptureCommand, EndsInAMeshOfWhatTheCameraSaw) {
  (void)desk_view();  // rendered before the camera's clock runs
  EmulatedBus bus;
  bus.plug(camera_at_the_desk());
  TempFolder out;
  ASSERT_EQ(scanknit({"capture", "-o", (out / "desk.ply").string(), "--report", (out / "report.json").string(), "--fps",
                      kRate, "--frames", std::to_string(kPictures), "--set", "fusion.voxel_size=8mm"}),
            0);
  const json report = json::parse(read_text(out / "report.json"));
  EXPECT_EQ(report.at("losses").at("transport"), 0);
  EXPECT_EQ(report.at("losses").at("device"), 0);
  EXPECT_EQ(report.at("frames").at("lost"), 0);
  EXPECT_GE(report.at("frames").at("fused"), 5);
  const std::uint64_t first = report.at("tracking").at("frames").at(0).at("frame");
  EXPECT_LT(mean_error_m(out / "desk.ply", first), kQuarterVoxel_m);

  // All pictures are in the recording, whatever was too late for fusion; it is fused like any other.
  AcquireConfig config;
  config.poses = PoseMode::kTrack;
  const auto recording = open_recording(out / "desk.mcap", config);
  ASSERT_TRUE(recording) << recording.error().text();
  EXPECT_GE((*recording)->info().frames, static_cast<std::size_t>(kPictures));
  const auto fuse = [&](const char* name) {
    EXPECT_EQ(scanknit({"run", (out / "desk.mcap").string(), "-o", (out / name).string(), "--to", "20", "--set",
                        "fusion.voxel_size=8mm"}),
              0);
    return read_text(out / name);
  };
  EXPECT_EQ(fuse("once.ply"), fuse("twice.ply"));
  EXPECT_LT(mean_error_m(out / "once.ply", 0), kQuarterVoxel_m);
}

TEST(CaptureCommand, UnpluggedForGoodKeepsWhatWasScanned) {
  (void)desk_view();
  EmulatedBus bus;
  const int address = bus.plug(camera_at_the_desk());
  TempFolder out;
  std::jthread hand([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(1500));
    bus.unplug(address);
  });
  EXPECT_EQ(scanknit({"capture", "-o", (out / "desk.ply").string(), "--report", (out / "report.json").string(), "--fps",
                      kRate, "--reconnect", "0", "--set", "fusion.voxel_size=8mm"}),
            5);
  const json report = json::parse(read_text(out / "report.json"));
  EXPECT_EQ(report.at("exit_code"), 5);
  EXPECT_LT(mean_error_m(out / "desk.ply", report.at("tracking").at("frames").at(0).at("frame")), kQuarterVoxel_m);
}

TEST(CaptureCommand, PutsTheRecordingIntoTheFolderOfTheMesh) {
  (void)desk_view();
  EmulatedBus bus;
  bus.plug(camera_at_the_desk());
  TempFolder out;
  ASSERT_EQ(scanknit({"capture", "-o", (out / "scan").string(), "--fps", kRate, "--seconds", "0.5", "--set",
                      "fusion.voxel_size=8mm"}),
            0);
  for (const char* name :
       {"model.glb", "model.ply", "preview.png", "report.json", "trajectory.txt", "recording.mcap"}) {
    EXPECT_GT(std::filesystem::file_size(out / "scan" / name), 0u) << name;
  }
  const json report = json::parse(read_text(out / "scan" / "report.json"));
  EXPECT_EQ(report.at("input"), "usb:8086:0b07/0123456789ab");
}

TEST(CaptureCommand, WithoutACameraExitsWith5) {
  EmulatedBus bus;
  TempFolder out;
  EXPECT_EQ(scanknit({"capture", "-o", (out / "desk.ply").string()}), 5);
  EXPECT_FALSE(std::filesystem::exists(out / "desk.ply"));
  EXPECT_FALSE(std::filesystem::exists(out / "desk.mcap"));
}

TEST(CaptureCommand, KnowsNoRecordedPoses) {
  EmulatedBus bus;
  TempFolder out;
  EXPECT_EQ(scanknit({"capture", "-o", (out / "desk.ply").string(), "--poses", "recording"}), 2);
}

TEST(RecordCommand, KeepsEveryPicture) {
  EmulatedBus bus;
  bus.plug({});  // depth and colour
  TempFolder out;
  ASSERT_EQ(scanknit({"record", "-o", (out / "scan.mcap").string(), "--frames", "30"}), 0);
  AcquireConfig config;
  config.poses = PoseMode::kTrack;
  const auto recording = open_recording(out / "scan.mcap", config);
  ASSERT_TRUE(recording) << recording.error().text();
  EXPECT_GE((*recording)->info().frames, 30u);
  EXPECT_TRUE((*recording)->info().has_colour);
  EXPECT_EQ((*recording)->info().intrinsics, (CameraIntrinsics{640, 480, 380, 381, 319, 241}));
  // Never over one that is there.
  EXPECT_EQ(scanknit({"record", "-o", (out / "scan.mcap").string(), "--frames", "30"}), 8);
}

}  // namespace
}  // namespace scanknit::test
