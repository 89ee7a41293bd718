// export.uncertainty: the standard deviation of each vertex, against the exact surface of a synthetic scene.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "export/mesh/read_mesh.h"
#include "scan/mesh/vertex_uncertainty.h"
#include "scan/mesh/view_spread.h"
#include "scan/scan.h"
#include "scan/volume/extract_volume.h"
#include "synth/scene/scene.h"
#include "synth/write_recording.h"
#include "tests/core/temporary_folder.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;

class Quiet final : public ScanObserver {};

std::string bytes_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// The property of a PLY file with normals and colours, the last of its vertices; empty when it has none.
std::vector<float> uncertainty_in(const fs::path& ply) {
  const std::string bytes = bytes_of(ply);
  const std::string end = "end_header\n";
  const std::size_t head = bytes.find(end);
  const std::string text = bytes.substr(0, head);
  if (text.find("\nproperty uchar blue\nproperty float uncertainty\nelement face ") == std::string::npos) return {};
  EXPECT_NE(text.find("\nproperty float nz\nproperty uchar red\n"), std::string::npos);
  const std::size_t count = std::stoul(text.substr(text.find("element vertex ") + 15));
  constexpr std::size_t kStride = 6 * sizeof(float) + 3 + sizeof(float);
  std::vector<float> values(count);
  for (std::size_t i = 0; i < count; ++i) {
    std::memcpy(&values[i], bytes.data() + head + end.size() + (i + 1) * kStride - sizeof(float), sizeof(float));
  }
  return values;
}

bool same_values(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

/// A noisy recording of a scene with known poses, and what is made of it.
class VertexUncertainty : public ::testing::Test {
 protected:
  void record(const char* scene, int frames) {
    SynthConfig config;
    config.frames = frames;
    config.intrinsics = {320, 240, 262.5, 262.5, 159.5, 119.5};
    config.noise = true;
    write(scene, config);
  }

  /// With one frame a second: the whole way in few frames would be too quick for a rolling shutter.
  void record_with(const char* sensor, const char* scene, int frames) {
    auto made = make_sensor(sensor);
    ASSERT_TRUE(made);
    SynthConfig config;
    config.frames = frames;
    config.sensor = *std::move(made);
    config.sensor->time.rate_hz = 1;
    config.intrinsics = camera_of(*config.sensor, 320, 240);
    write(scene, config);
  }

  void write(const char* scene, const SynthConfig& config) {
    auto made = make_scene(scene);
    ASSERT_TRUE(made);
    scene_ = *std::move(made);
    ASSERT_TRUE(write_synthetic_recording(*scene_, config, folder_ / "recording"));
  }

  [[nodiscard]] ScanJob job(const char* mesh) const {
    ScanJob job;
    job.input = folder_ / "recording";
    job.config.fusion.voxel_size_m = 0.008;
    job.config.output.uncertainty = true;
    job.files.meshes = {folder_ / mesh};
    return job;
  }

  [[nodiscard]] static ScanResult scan(const ScanJob& job) {
    Quiet quiet;
    ScanResult result = scan_recording(job, quiet);
    EXPECT_TRUE(result.outcome) << result.outcome.error().text();
    return result;
  }

  /// Of the vertices whose uncertainty is known: the share that lies within two of it of the exact surface.
  [[nodiscard]] double share_within_two(const fs::path& ply) const {
    const auto mesh = read_mesh(ply);
    const std::vector<float> sigma_m = uncertainty_in(ply);
    EXPECT_TRUE(mesh);
    EXPECT_EQ(sigma_m.size(), mesh->positions_m.size());
    std::size_t known = 0, within = 0;
    for (std::size_t i = 0; i < sigma_m.size(); ++i) {
      if (std::isnan(sigma_m[i])) continue;
      ++known;
      const double error_m = scene_->surface_distance(mesh->positions_m[i].cast<double>());
      within += error_m <= 2 * static_cast<double>(sigma_m[i]) ? 1 : 0;
    }
    EXPECT_GT(known, 1000u);
    const double share = static_cast<double>(within) / static_cast<double>(known);
    std::cout << "share within two: " << share << "\n";  // the figures of docs/formats.md
    return share;
  }

  TemporaryFolder folder_;
  std::unique_ptr<SyntheticScene> scene_;
};

TEST_F(VertexUncertainty, HoldsTheErrorsOfATower) {
  ASSERT_NO_FATAL_FAILURE(record("tower", 16));
  const ScanResult result = scan(job("model.ply"));
  const double share = share_within_two(folder_ / "model.ply");
  EXPECT_GE(share, 0.85);
  EXPECT_LE(share, 0.99);
  EXPECT_EQ(result.files.at("uncertainty"), (folder_ / "model_uncertainty.png").string());
  EXPECT_GT(fs::file_size(folder_ / "model_uncertainty.png"), 1000u);
}

TEST_F(VertexUncertainty, HoldsTheErrorsOfADesk) {
  ASSERT_NO_FATAL_FAILURE(record("desk", 16));
  ScanJob coarse = job("model.ply");
  coarse.config.fusion.voxel_size_m = 0.012;
  (void)scan(coarse);
  const double share = share_within_two(folder_ / "model.ply");
  EXPECT_GE(share, 0.85);
  EXPECT_LE(share, 0.99);
}

struct SensedScene {
  const char* sensor;
  const char* scene;
};

class SensorUncertainty : public VertexUncertainty, public ::testing::WithParamInterface<SensedScene> {};

TEST_P(SensorUncertainty, HoldsTheErrors) {
  ASSERT_NO_FATAL_FAILURE(record_with(GetParam().sensor, GetParam().scene, 30));
  (void)scan(job("model.ply"));
  const double share = share_within_two(folder_ / "model.ply");
  EXPECT_GE(share, 0.85);
  EXPECT_LE(share, 0.99);
}

INSTANTIATE_TEST_SUITE_P(Sensors, SensorUncertainty,
                         ::testing::Values(SensedScene{"kinect1", "tower"}, SensedScene{"kinect1", "turntable"},
                                           SensedScene{"kinect1", "desk"}, SensedScene{"kinect1", "room"},
                                           SensedScene{"d435", "tower"}, SensedScene{"d435", "turntable"},
                                           SensedScene{"d435", "desk"}, SensedScene{"d435", "room"},
                                           SensedScene{"phone_lidar", "tower"}, SensedScene{"phone_lidar", "room"}),
                         [](const auto& row) { return std::string(row.param.sensor) + "_" + row.param.scene; });

TEST_F(VertexUncertainty, ChangesNothingElse) {
  ASSERT_NO_FATAL_FAILURE(record("tower", 6));
  (void)scan(job("with.ply"));
  ScanJob without = job("without.ply");
  without.config.output.uncertainty = false;
  without.files.volume = folder_ / "without.vdb";
  const ScanResult result = scan(without);
  EXPECT_EQ(result.files.count("uncertainty"), 0u);
  EXPECT_FALSE(fs::exists(folder_ / "without_uncertainty.png"));
  EXPECT_EQ(bytes_of(folder_ / "without.ply").find("uncertainty"), std::string::npos);
  EXPECT_EQ(bytes_of(folder_ / "without.vdb").find("view_sigma_m"), std::string::npos);
  const auto a = read_mesh(folder_ / "with.ply"), b = read_mesh(folder_ / "without.ply");
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->positions_m, b->positions_m);
  EXPECT_EQ(a->triangles.size(), b->triangles.size());
}

TEST_F(VertexUncertainty, IsTheSameOfASavedVolumeAndInBricks) {
  ASSERT_NO_FATAL_FAILURE(record("tower", 6));
  ScanJob whole = job("whole.ply");
  whole.config.noise.floor_m = 0.002;  // a sensor that the extraction cannot guess
  whole.config.finish.drops_crumbs = false;
  whole.files.volume = folder_ / "volume.vdb";
  (void)scan(whole);
  const std::vector<float> of_scan = uncertainty_in(folder_ / "whole.ply");
  ASSERT_GT(of_scan.size(), 1000u);

  ScanJob bricks = whole;
  bricks.files.meshes = {folder_ / "bricks.ply"};
  bricks.files.volume.reset();
  bricks.config.fusion.bricks = BrickSize::k64;
  (void)scan(bricks);
  EXPECT_TRUE(same_values(of_scan, uncertainty_in(folder_ / "bricks.ply")));

  ScanJob extraction;
  extraction.input = folder_ / "volume.vdb";
  extraction.config.extract = whole.config.extract;
  extraction.config.output.uncertainty = true;
  extraction.files.meshes = {folder_ / "extracted.ply"};
  Quiet quiet;
  const ScanResult extracted = extract_volume(extraction, {}, quiet);
  ASSERT_TRUE(extracted.outcome) << extracted.outcome.error().text();
  EXPECT_EQ(find_warning(extracted, WarningCode::kVolumeFile), nullptr);
  EXPECT_TRUE(same_values(of_scan, uncertainty_in(folder_ / "extracted.ply")));
}

TEST_F(VertexUncertainty, SaysWhatItAssumesOfAVolumeThatDoesNotSayItsNoise) {
  ASSERT_NO_FATAL_FAILURE(record("tower", 4));
  ScanJob silent = job("model.ply");
  silent.config.output.uncertainty = false;
  silent.files.volume = folder_ / "volume.vdb";
  (void)scan(silent);
  ScanJob extraction;
  extraction.input = folder_ / "volume.vdb";
  extraction.config.output.uncertainty = true;
  extraction.files.meshes = {folder_ / "extracted.ply"};
  Quiet quiet;
  const ScanResult extracted = extract_volume(extraction, {}, quiet);
  ASSERT_TRUE(extracted.outcome) << extracted.outcome.error().text();
  const ScanWarning* warning = find_warning(extracted, WarningCode::kVolumeFile);
  ASSERT_NE(warning, nullptr);
  EXPECT_NE(warning->text.find("1.2 mm"), std::string::npos) << warning->text;
  EXPECT_FALSE(uncertainty_in(folder_ / "extracted.ply").empty());
}

TEST_F(VertexUncertainty, IsNotANumberWhereNothingWasSeen) {
  ASSERT_NO_FATAL_FAILURE(record("tower", 6));
  ScanJob closed = job("closed.ply");
  closed.config.finish.watertight = Watertight::kFull;
  closed.config.finish.smooth_steps = 3;
  (void)scan(closed);
  const std::vector<float> sigma_m = uncertainty_in(folder_ / "closed.ply");
  const auto unknown = std::count_if(sigma_m.begin(), sigma_m.end(), [](float s) { return std::isnan(s); });
  EXPECT_GT(unknown, 0);
  EXPECT_LT(unknown, static_cast<std::ptrdiff_t>(sigma_m.size()) / 2);
  for (const float sigma : sigma_m) EXPECT_TRUE(std::isnan(sigma) || (sigma > 0 && sigma < 1));
}

TEST(ViewSpread, IsTheSensorsNoiseWithoutViewsOfOnePlace) {
  EXPECT_EQ(ViewSpread({}, {.floor_m = 0.002}).view_sigma_m(), 0.002);
}

TEST(Uncertainty, FallsWithTheWeightToTheFloorOfTheVoxels) {
  const UncertaintyScale scale{0.0012, 0.004};
  EXPECT_TRUE(std::isnan(uncertainty_m(0, 0, scale)));
  const float once = uncertainty_m(1, 0, scale), often = uncertainty_m(100, 0, scale);
  const float always = uncertainty_m(4000, 0, scale);
  EXPECT_GT(once, often);
  EXPECT_GT(often, always);
  EXPECT_GT(always, 0.0f);
  EXPECT_GT(uncertainty_m(1, 0, {0.0024, 0.004}), once);
  EXPECT_GT(uncertainty_m(4000, 0, {0.0012, 0.008}), always);
  EXPECT_GT(uncertainty_m(4000, 0.004f, scale), 0.0005f);  // at an edge
}

}  // namespace
}  // namespace scanknit::test
