// Pairs of infrared pictures, from an emulated RealSense that looks at a synthetic scene to the mesh.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "acquire/frame_source.h"
#include "app/cli/cli.h"
#include "export/mesh/read_mesh.h"
#include "synth/surface_error.h"
#include "tests/app/program.h"
#include "tests/scan/stereo_pictures.h"
#include "tests/usb/emulated/desk_view.h"
#include "tests/usb/emulated/emulated_bus.h"

namespace scanknit::test {
namespace {

using nlohmann::json;

namespace fs = std::filesystem;

constexpr int kPairs = 10;
constexpr double kVoxel_m = 0.004;

int scanknit_with(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {"scanknit"});
  std::vector<const char*> argv;
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  return run_cli(static_cast<int>(argv.size()), argv.data());
}

/// What a RealSense's two infrared cameras see of a scene from these places.
class PairView {
 public:
  PairView(const char* scene, int steps, bool walks)
      : scene_(make_scene(scene).value()), T_world_left_(camera_path(*scene_, steps)) {
    for (std::size_t n = 0; n < kPairs; ++n) {  // each with noise of its own
      const Pose T_world_left = T_world_left_[walks ? n : 0];
      const Pose T_world_right = T_world_left * rig_.T_right_left.inverse();
      left_.push_back(grey(photograph(*scene_, rig_, T_world_left, 2 * n)));
      right_.push_back(grey(photograph(*scene_, rig_, T_world_right, 2 * n + 1)));
    }
  }

  [[nodiscard]] std::vector<std::byte> y8i(std::uint64_t n) const {
    const std::size_t at = std::min<std::size_t>(n, kPairs - 1);
    std::vector<std::byte> bytes;
    for (std::size_t i = 0; i < left_[at].size(); ++i) {
      bytes.push_back(std::byte{left_[at].pixels()[i].g});
      bytes.push_back(std::byte{right_[at].pixels()[i].g});
    }
    return bytes;
  }

  /// The same pairs as a folder.
  void write(const fs::path& folder) const {
    for (const auto& [name, side] : {std::pair("left", &left_), {"right", &right_}}) {
      fs::create_directories(folder / name);
      for (std::size_t n = 0; n < side->size(); ++n) {
        ASSERT_TRUE(write_colour_png((*side)[n], folder / name / fmt::format("{:06}.png", n)));
      }
    }
    write_text(folder / "stereo.yaml", rig_.yaml());
  }

  /// Mean distance of the vertices from the scene; the mesh is in the frame of that left camera.
  [[nodiscard]] double mean_error_m(const fs::path& file, std::size_t first = 0) const {
    auto mesh = read_mesh(file);
    EXPECT_TRUE(mesh);
    if (!mesh) return 1;
    EXPECT_GT(mesh->positions_m.size(), 1000u);
    const Eigen::Isometry3f T_world_mesh = T_world_left_.at(first).cast<float>();
    for (Eigen::Vector3f& p : mesh->positions_m) p = T_world_mesh * p;
    const auto error = measure_surface(*mesh, *scene_, {});
    EXPECT_TRUE(error);
    return error ? error->vertices.mean_m : 1;
  }

 private:
  [[nodiscard]] static ColourImage grey(ColourImage picture) {
    for (Rgb8& p : picture.pixels()) p.r = p.g = p.b = static_cast<std::uint8_t>((p.r + 2 * p.g + p.b) / 4);
    return picture;
  }

  RigOnPaper rig_{.camera = emulated_intrinsics(),
                  .baseline_m = 0.05,  // realsense_bytes.h
                  .T_right_left = Pose(Eigen::Translation3d(-0.05, 0, 0))};
  std::unique_ptr<SyntheticScene> scene_;
  std::vector<Pose> T_world_left_;
  std::vector<ColourImage> left_, right_;
};

const PairView& pair_view() {
  static const PairView view("turntable", 24, false);
  return view;
}

VcamOptions camera_of_pairs(const PairView& view = pair_view()) {
  VcamOptions options;
  options.has_colour = false;
  options.has_infrared = true;
  options.infrared_pair = [&view](std::uint64_t n) { return view.y8i(n); };
  return options;
}

std::vector<Frame> frames_of(const fs::path& recording, Geometry geometry) {
  AcquireConfig config;
  config.geometry = geometry;
  config.poses = PoseMode::kTrack;
  std::vector<Frame> frames;
  auto source = open_recording(recording, config);
  EXPECT_TRUE(source) << source.error().text();
  if (!source) return frames;
  EXPECT_TRUE((*source)->info().has_colour);
  EXPECT_TRUE((*source)->info().sensor && (*source)->info().sensor->own_noise);
  for (;;) {
    FrameEvent event = (*source)->next({});
    auto* frame = std::get_if<Frame>(&event);
    if (frame == nullptr) return frames;
    frames.push_back(std::move(*frame));
  }
}

/// With what the emulated camera has to be asked for.
std::vector<std::string> command_of(const std::string& command, const fs::path& out) {
  return {command, "-o", out.string(), "--geometry", "stereo", "--fps", "15", "--frames", std::to_string(kPairs)};
}

const std::string kVoxels = "fusion.voxel_size=4mm";

TEST(CaptureOfPairs, EndsInAMeshAsExactAsThatOfTheSamePairsInAFolder) {
  TempFolder out;
  ASSERT_NO_FATAL_FAILURE(pair_view().write(out / "pairs"));
  EmulatedBus bus;
  bus.plug(camera_of_pairs());
  std::vector<std::string> capture = command_of("capture", out / "live.ply");
  capture.insert(capture.end(), {"--poses", "still", "--report", (out / "report.json").string(), "--set", kVoxels});
  ASSERT_EQ(scanknit_with(capture), 0);
  const json report = json::parse(read_text(out / "report.json"));
  EXPECT_EQ(report.at("losses").at("transport"), 0);
  EXPECT_EQ(report.at("frames").at("lost"), 0);
  EXPECT_GE(report.at("frames").at("fused"), 1);
  const double live_m = pair_view().mean_error_m(out / "live.ply");

  // The recording has all pairs, and its depth the same bits as the folder's.
  const std::vector<Frame> replayed = frames_of(out / "live.mcap", Geometry::kStereo);
  const std::vector<Frame> expected = frames_of(out / "pairs", Geometry::kStereo);
  ASSERT_EQ(replayed.size(), static_cast<std::size_t>(kPairs));
  ASSERT_EQ(expected.size(), replayed.size());
  for (std::size_t n = 0; n < replayed.size(); ++n) {
    EXPECT_TRUE(std::ranges::equal(replayed[n].depth_m.pixels(), expected[n].depth_m.pixels())) << n;
    ASSERT_TRUE(replayed[n].colour);
    EXPECT_TRUE(replayed[n].colour->image == expected[n].colour->image) << n << ": the left picture is the colour";
  }
  EXPECT_EQ(frames_of(out / "live.mcap", Geometry::kDepth).size(), replayed.size()) << "it need not be said again";

  const auto run = [&](const char* recording, const char* mesh) {
    EXPECT_EQ(scanknit_with({"run", (out / recording).string(), "-o", (out / mesh).string(), "--geometry", "stereo",
                             "--poses", "still", "--set", kVoxels}),
              0);
    return pair_view().mean_error_m(out / mesh);
  };
  const double folder_m = run("pairs", "folder.ply");
  const double replayed_m = run("live.mcap", "replayed.ply");
  fmt::print("mean error of the mesh: capture {:.4f} mm, its recording {:.4f} mm, the folder {:.4f} mm\n", 1e3 * live_m,
             1e3 * replayed_m, 1e3 * folder_m);
  EXPECT_LT(folder_m, kVoxel_m / 2);
  EXPECT_NEAR(replayed_m, folder_m, kVoxel_m / 100) << "only the times differ";
  EXPECT_NEAR(live_m, folder_m, kVoxel_m / 4) << "fewer pairs, perhaps: a newer one was there already";
}

/// Where there is enough to see, the scanner is tracked by what pairs give, coarse as it is in a room.
TEST(CaptureOfPairs, IsTracked) {
  const PairView desk("desk", 600, true);
  EmulatedBus bus;
  bus.plug(camera_of_pairs(desk));
  TempFolder out;
  std::vector<std::string> capture = command_of("capture", out / "desk.ply");
  capture.insert(capture.end(), {"--report", (out / "report.json").string(), "--set", "fusion.voxel_size=1cm"});
  ASSERT_EQ(scanknit_with(capture), 0);
  const json report = json::parse(read_text(out / "report.json"));
  EXPECT_EQ(report.at("frames").at("lost"), 0);
  const double error_m = desk.mean_error_m(out / "desk.ply", report.at("tracking").at("frames").at(0).at("frame"));
  fmt::print("mean error of the tracked mesh: {:.2f} mm\n", 1e3 * error_m);
  EXPECT_LT(error_m, 0.03);
}

TEST(RecordOfPairs, KeepsThemForRun) {
  (void)pair_view();  // rendered before the camera's clock runs
  EmulatedBus bus;
  bus.plug(camera_of_pairs());
  TempFolder out;
  ASSERT_EQ(scanknit_with(command_of("record", out / "pairs.mcap")), 0);
  EXPECT_EQ(frames_of(out / "pairs.mcap", Geometry::kStereo).size(), static_cast<std::size_t>(kPairs));
  std::vector<std::string> ros2 = command_of("record", out / "bag.mcap");
  ros2.emplace_back("--ros2");
  EXPECT_EQ(scanknit_with(ros2), 2) << "that has depth";
  // Cameras of the user's own would contradict those that are in the file.
  EXPECT_EQ(scanknit_with({"run", (out / "pairs.mcap").string(), "-o", (out / "mesh.ply").string(), "--set",
                           "acquire.intrinsics=[380,381,319,241]"}),
            3);
}

/// The exit code of a capture of pairs from that camera, and what it says.
Outcome capture_from(const VcamOptions& camera, const std::vector<std::string>& more = {},
                     const std::function<void(Vcam&)>& spoil = {}) {
  EmulatedBus bus;
  const int address = bus.plug(camera);
  if (spoil) bus.with_camera(address, spoil);
  TempFolder out;
  std::vector<std::string> capture = command_of("capture", out / "mesh.ply");
  capture.insert(capture.end(), more.begin(), more.end());
  testing::internal::CaptureStderr();
  const int exit_code = scanknit_with(capture);
  return {exit_code, "", testing::internal::GetCapturedStderr()};
}

TEST(CaptureOfPairs, NeedsACameraThatSendsThem) {
  const Outcome without = capture_from({.has_colour = false});
  EXPECT_EQ(without.exit_code, 5);
  EXPECT_NE(without.err.find("offers no pairs of infrared pictures"), std::string::npos) << without.err;
}

TEST(CaptureOfPairs, NeedsTheCamerasOwnCalibration) {
  const auto spoil = [](Vcam& camera) { camera.control_faults.has_no_calibration = true; };
  const Outcome unknown = capture_from({.has_colour = false, .has_infrared = true}, {}, spoil);
  EXPECT_EQ(unknown.exit_code, 5);
  EXPECT_NE(unknown.err.find("acquire.geometry=depth"), std::string::npos) << unknown.err;
  const Outcome stated =
      capture_from({.has_colour = false, .has_infrared = true}, {"--set", "acquire.intrinsics=[380,381,319,241]"});
  EXPECT_EQ(stated.exit_code, 3) << stated.err;
}

}  // namespace
}  // namespace scanknit::test
