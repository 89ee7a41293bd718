// From pictures with masks to a mesh.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "acquire/convert/picture_files.h"
#include "core/files/read_file.h"
#include "core/picture/decode_picture.h"
#include "core/rotation.h"
#include "scan/scan.h"
#include "synth/render.h"
#include "synth/scene/scene.h"
#include "synth/write_recording.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

/// A ring of `around` by `across` points, longer along x, and higher at one end: from every side another outline.
Mesh skewed_ring(double radius_m, double thickness_m, std::uint32_t around, std::uint32_t across) {
  Mesh mesh;
  for (std::uint32_t i = 0; i < around; ++i) {
    const double turn = kFullTurn * i / around;
    for (std::uint32_t k = 0; k < across; ++k) {
      const double roll = kFullTurn * k / across;
      const double from_axis = radius_m + thickness_m * std::cos(roll);
      mesh.positions_m.push_back(
          Eigen::Vector3d(1.5 * from_axis * std::sin(turn),
                          thickness_m * std::sin(roll) + 0.5 * from_axis * std::max(0.0, std::sin(turn)),
                          from_axis * std::cos(turn))
              .cast<float>());
      const auto at = [&](std::uint32_t a, std::uint32_t b) { return (a % around) * across + b % across; };
      mesh.triangles.emplace_back(at(i, k), at(i + 1, k), at(i + 1, k + 1));
      mesh.triangles.emplace_back(at(i, k), at(i + 1, k + 1), at(i, k + 1));
    }
  }
  return mesh;
}

class Silhouettes : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("scanknit_silhouettes_" + std::to_string(::getpid()));
    SynthConfig config;
    config.frames = 20;
    config.intrinsics = {160, 120, 131.25, 131.25, 79.5, 59.5};
    config.masks = true;
    const auto scene = make_mesh_scene(skewed_ring(0.08, 0.03, 40, 20), 0.22);
    ASSERT_TRUE(scene) << scene.error().text();
    ASSERT_TRUE(write_synthetic_recording(**scene, config, pictures()));
    fs::remove_all(pictures() / "depth");
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] fs::path pictures() const { return folder_ / "pictures"; }
  [[nodiscard]] ScanJob job() const {
    ScanJob job;
    job.input = pictures();
    job.config.acquire.geometry = Geometry::kSilhouettes;
    job.files.meshes = {folder_ / "out" / "model.ply"};
    job.files.trajectory = folder_ / "out" / "trajectory.txt";
    return job;
  }
  [[nodiscard]] std::string bytes_of_mesh() const {
    std::ifstream file(folder_ / "out" / "model.ply", std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  [[nodiscard]] ScanResult scanned(const ScanJob& asked) const {
    ScanObserver nobody;
    return scan_recording(asked, nobody);
  }
  void fill_mask(int number, std::uint8_t value) const {
    const ColourImage mask(160, 120, Rgb8{value, value, value});
    ASSERT_TRUE(write_colour_png(mask, pictures() / "masks" / ("00000" + std::to_string(number) + ".png")));
  }

 private:
  fs::path folder_;
};

TEST_F(Silhouettes, BecomeAClosedMeshThatFillsThem) {
  const ScanResult result = scanned(job());
  ASSERT_TRUE(result.outcome) << result.outcome.error().text();
  ASSERT_TRUE(result.mesh.check);
  EXPECT_TRUE(result.mesh.check->is_closed());
  EXPECT_TRUE(result.mesh.check->is_manifold());
  EXPECT_EQ(result.mesh.check->components, 1u);
  EXPECT_EQ(result.frames.fused, 20u);
  EXPECT_EQ(result.trajectory.size(), 20u);
  ASSERT_TRUE(result.silhouettes);
  EXPECT_EQ(result.silhouettes->pictures, 20u);
  EXPECT_GT(result.silhouettes->agreement, 0.995);
  EXPECT_GT(result.silhouettes->worst_overlap, 0.93) << "outlines of 45 pixels";
  EXPECT_TRUE(result.warnings.empty()) << result.warnings.front().text;
  const Eigen::Vector3f size = result.mesh.check->max_m - result.mesh.check->min_m;
  EXPECT_NEAR(size.x(), 0.22, 0.004) << "as large as the thing, where outlines bound it";
  EXPECT_NEAR(size.z(), 0.22 / 1.5, 0.004);
  constexpr double kPixel_m = 3 * 0.22 / 131.25;  // the cameras are three times as far as the thing is long
  EXPECT_NEAR(result.config.fusion.voxel_size_m, kPixel_m, 0.1 * kPixel_m);
  EXPECT_TRUE(result.files.contains("trajectory"));
}

/// Pictures of a thing that turns before a camera that looks down at it.
class TurnedThing : public Silhouettes {
 protected:
  static constexpr int kTurned = 36;
  static constexpr double kFromAxis_m = 0.7;
  static constexpr CameraIntrinsics kStillCamera{640, 480, 900, 900, 319.5, 239.5};

  /// The camera as the thing sees it when it has turned by `angle_rad` round the world's y axis.
  [[nodiscard]] static Pose camera_at(double angle_rad) {
    constexpr double kDown = 25 * kDegree;
    Pose first = Pose::Identity();
    first.rotate(Eigen::AngleAxisd(-kDown, Eigen::Vector3d::UnitX()));
    first.translation() = kFromAxis_m * Eigen::Vector3d(0, -std::sin(kDown), -std::cos(kDown));
    return Eigen::AngleAxisd(-angle_rad, Eigen::Vector3d::UnitY()) * first;
  }

  void render_turn() const {
    const auto scene = make_mesh_scene(skewed_ring(0.08, 0.03, 40, 20), 0.22);
    ASSERT_TRUE(scene);
    fs::remove_all(pictures());
    for (const char* part : {"color", "masks"}) fs::create_directories(pictures() / part);
    ASSERT_TRUE(write_camera_json(kStillCamera, 1000, pictures() / "camera_intrinsic.json"));
    for (int i = 0; i < kTurned; ++i) {
      const RenderedView view = render(**scene, kStillCamera, camera_at(kFullTurn * i / kTurned));
      ColourImage mask(kStillCamera.width, kStillCamera.height);
      for (std::size_t k = 0; k < mask.size(); ++k) {
        if (view.depth_m.pixels()[k] > 0) mask.pixels()[k] = Rgb8{255, 255, 255};
      }
      const std::string name = fmt::format("{:03}.png", i);
      ASSERT_TRUE(write_colour_png(view.colour, pictures() / "color" / name));
      ASSERT_TRUE(write_colour_png(mask, pictures() / "masks" / name));
    }
  }
};

TEST_F(TurnedThing, HasItsAxisFound) {
  ASSERT_NO_FATAL_FAILURE(render_turn());
  ScanJob turned = job();
  turned.config.turntable.is_enabled = true;
  turned.config.turntable.distance_m = kFromAxis_m;
  const ScanResult result = scanned(turned);
  ASSERT_TRUE(result.outcome) << result.outcome.error().text();
  ASSERT_EQ(result.trajectory.size(), static_cast<std::size_t>(kTurned));
  for (int i = 0; i < kTurned; ++i) {
    const Pose& found = result.trajectory[static_cast<std::size_t>(i)].T_world_camera;
    const Pose truth = camera_at(0).inverse() * camera_at(kFullTurn * i / kTurned);
    EXPECT_LT(Eigen::AngleAxisd((found.inverse() * truth).linear()).angle(), 0.2 * kDegree) << i;
    EXPECT_LT((found.translation() - truth.translation()).norm(), 0.001) << i;
  }
  EXPECT_TRUE(result.mesh.check->is_closed());
  ASSERT_TRUE(result.silhouettes);
  EXPECT_GT(result.silhouettes->worst_overlap, 0.95);
  EXPECT_TRUE(result.warnings.empty()) << result.warnings.front().text;

  turned.config.turntable.distance_m = std::nullopt;
  turned.config.turntable.step_degrees = 360.0 / kTurned;
  EXPECT_TRUE(find_warning(scanned(turned), WarningCode::kTurntable)) << "its size is not known";
  turned.config.turntable.step_degrees = 3;
  EXPECT_FALSE(scanned(turned).outcome) << "no axis explains them";
}

TEST_F(Silhouettes, GiveTheSameBytesAgain) {
  ASSERT_TRUE(scanned(job()).outcome);
  const std::string first = bytes_of_mesh();
  ASSERT_FALSE(first.empty());
  ASSERT_TRUE(scanned(job()).outcome);
  EXPECT_TRUE(first == bytes_of_mesh());
}

TEST_F(Silhouettes, DropAPictureWhoseMaskSaysNothing) {
  fill_mask(3, 255);
  fill_mask(5, 0);
  const ScanResult result = scanned(job());
  ASSERT_TRUE(result.outcome) << result.outcome.error().text();
  EXPECT_EQ(result.frames.fused, 18u);
  EXPECT_EQ(result.frames.dropped, 2u);
  ASSERT_EQ(result.frames.drop_messages.size(), 2u);
  EXPECT_NE(result.frames.drop_messages[0].find("000003.png"), std::string::npos);
  EXPECT_NE(result.frames.drop_messages[0].find("white all over"), std::string::npos);
  EXPECT_NE(result.frames.drop_messages[1].find("the mask is empty"), std::string::npos);
  ASSERT_TRUE(find_warning(result, WarningCode::kFramesDropped));
}

TEST_F(Silhouettes, WarnIfOneDoesNotFitTheOthers) {
  const fs::path file = pictures() / "masks" / "000002.png";
  const auto bytes = read_file(file, 1 << 20);
  ASSERT_TRUE(bytes);
  const auto mask = decode_picture(*bytes, Limits());
  ASSERT_TRUE(mask);
  constexpr int kOff = 16;  // pixels to the right
  ColourImage moved(mask->width(), mask->height());
  for (int y = 0; y < mask->height(); ++y) {
    for (int x = kOff; x < mask->width(); ++x) moved.at(x, y) = mask->at(x - kOff, y);
  }
  ASSERT_TRUE(write_colour_png(moved, file));
  const ScanResult result = scanned(job());
  ASSERT_TRUE(result.outcome) << result.outcome.error().text();
  ASSERT_TRUE(result.silhouettes);
  EXPECT_LT(result.silhouettes->worst_overlap, 0.8);
  const ScanWarning* warning = find_warning(result, WarningCode::kSilhouettes);
  ASSERT_NE(warning, nullptr);
  EXPECT_NE(warning->text.find(result.silhouettes->worst_picture), std::string::npos);
}

TEST_F(Silhouettes, SayWhatIsMissing) {
  const auto message = [&](const ScanJob& asked) {
    const ScanResult result = scanned(asked);
    return result.outcome ? std::string() : result.outcome.error().text();
  };
  fs::rename(pictures() / "masks", pictures() / "elsewhere");
  EXPECT_NE(message(job()).find("no mask of this picture"), std::string::npos);
  ScanJob named = job();
  named.config.acquire.masks = "elsewhere";
  EXPECT_EQ(message(named), "");
  fs::remove(pictures() / "trajectory.log");
  EXPECT_NE(message(named).find("the pictures have no poses"), std::string::npos);
  fs::rename(pictures() / "color", pictures() / "other");
  EXPECT_NE(message(named).find("no pictures with known cameras"), std::string::npos);
}

TEST_F(Silhouettes, NeedAPictureOfEachSide) {
  ScanJob one = job();
  one.config.acquire.to = 0;
  const ScanResult result = scanned(one);
  ASSERT_FALSE(result.outcome);
  EXPECT_NE(result.outcome.error().message.find("at least two pictures"), std::string::npos);
}

}  // namespace
}  // namespace scanknit
