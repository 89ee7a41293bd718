// Rendered stereo pairs: how exact their disparities are, and the mesh that they become.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "acquire/frame_source.h"
#include "export/mesh/read_mesh.h"
#include "scan/frames/apply_sensor.h"
#include "scan/scan.h"
#include "synth/scene/scene.h"
#include "synth/surface_error.h"
#include "synth/write_recording.h"
#include "tests/core/temporary_folder.h"
#include "tests/scan/stereo_pictures.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

using test::RigOnPaper;
using test::TemporaryFolder;
using test::write_stereo_recording;
using test::write_text;

AcquireConfig stereo_config() {
  AcquireConfig config;
  config.geometry = Geometry::kStereo;
  return config;
}

std::vector<Frame> frames_of(const fs::path& folder) {
  std::vector<Frame> frames;
  auto source = open_recording(folder, stereo_config());
  EXPECT_TRUE(source) << source.error().text();
  if (!source) return frames;
  EXPECT_TRUE((*source)->info().warnings.empty()) << (*source)->info().warnings[0];
  for (;;) {
    FrameEvent event = (*source)->next({});
    if (const auto* drop = std::get_if<FrameDropped>(&event)) ADD_FAILURE() << drop->error.text();
    if (auto* frame = std::get_if<Frame>(&event)) {
      frames.push_back(std::move(*frame));
    } else if (!std::holds_alternative<FrameDropped>(event)) {
      return frames;
    }
  }
}

/// How disparities compare with the true ones, where the scene has a surface.
struct DisparityError {
  double median_px = 0;
  double share_known = 0;
  double share_wrong = 0;  ///< of those that are known: off by more than a pixel
};

DisparityError error_of(const Frame& frame, double baseline_m, const SyntheticScene& scene,
                        const Pose& T_world_camera) {
  const RenderedView truth = render(scene, frame.intrinsics, T_world_camera);
  std::vector<double> errors_px;
  std::size_t surface = 0;
  for (std::size_t i = 0; i < truth.depth_m.size(); ++i) {
    const double z_m = static_cast<double>(frame.depth_m.pixels()[i]);
    const double true_m = static_cast<double>(truth.depth_m.pixels()[i]);
    if (!(true_m > 0)) continue;
    ++surface;
    if (z_m > 0) errors_px.push_back(std::abs(frame.intrinsics.fx * baseline_m * (1 / z_m - 1 / true_m)));
  }
  if (errors_px.empty()) return {};
  std::sort(errors_px.begin(), errors_px.end());
  const auto known = static_cast<double>(errors_px.size());
  const auto wrong =
      static_cast<double>(std::distance(std::upper_bound(errors_px.begin(), errors_px.end(), 1.0), errors_px.end()));
  return {errors_px[errors_px.size() / 2], known / static_cast<double>(surface), wrong / known};
}

TEST(RenderedPairs, HaveDisparitiesOfAQuarterOfAPixelOrBetter) {
  for (const char* name : {"desk", "turntable"}) {
    const TemporaryFolder folder;
    const auto scene = make_scene(name);
    ASSERT_TRUE(scene);
    const RigOnPaper rig;
    const std::vector<Pose> poses = camera_path(**scene, 2);
    ASSERT_NO_FATAL_FAILURE(write_stereo_recording(**scene, rig, poses, folder.path()));
    const std::vector<Frame> frames = frames_of(folder.path());
    ASSERT_EQ(frames.size(), poses.size());
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const DisparityError error = error_of(frames[i], rig.baseline_m, **scene, poses[i]);
      SCOPED_TRACE(fmt::format("{} {}: median {:.3f} px, known {:.3f}, wrong {:.3f}", name, i, error.median_px,
                               error.share_known, error.share_wrong));
      EXPECT_LT(error.median_px, 0.15);
      EXPECT_GT(error.share_known, 0.7);
      EXPECT_LT(error.share_wrong, 0.05) << "at edges of things";
    }
  }
}

/// Two cameras that look in slightly different directions, through lenses: the pictures have to be rectified.
TEST(RenderedPairs, AreRectified) {
  const TemporaryFolder folder;
  const auto scene = make_scene("desk");
  ASSERT_TRUE(scene);
  RigOnPaper rig;
  rig.lens = {0.08, -0.05};
  rig.T_right_left = Pose(Eigen::Translation3d(-0.06, 0.002, 0.003) *
                          Eigen::AngleAxisd(0.03, Eigen::Vector3d(0.5, 1, 0.3).normalized()));
  const std::vector<Pose> poses = camera_path(**scene, 2);
  ASSERT_NO_FATAL_FAILURE(write_stereo_recording(**scene, rig, poses, folder.path()));
  std::string text;
  for (const char* side : {"left", "right"}) {
    text += fmt::format("{}: {{fx: 280, fy: 280, cx: 159.5, cy: 119.5, distortion: [0.08, -0.05, 0, 0, 0]}}\n", side);
  }
  text += "T_right_left: [";
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) text += fmt::format("{}, ", rig.T_right_left.matrix()(row, column));
  }
  write_text(folder / "stereo.yaml", text + "]\n");
  const std::vector<Frame> frames = frames_of(folder.path());
  ASSERT_EQ(frames.size(), poses.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    ASSERT_TRUE(frames[i].T_world_camera);
    EXPECT_FALSE(frames[i].T_world_camera->isApprox(poses[i])) << "the rectified camera is turned";
    const DisparityError error =
        error_of(frames[i], rig.T_right_left.translation().norm(), **scene, *frames[i].T_world_camera);
    SCOPED_TRACE(fmt::format("median {:.3f} px, known {:.3f}, wrong {:.3f}", error.median_px, error.share_known,
                             error.share_wrong));
    EXPECT_LT(error.median_px, 0.15);
    EXPECT_GT(error.share_known, 0.7);
    EXPECT_LT(error.share_wrong, 0.06);
  }
}

TEST(RenderedPairs, HaveTheNoiseOfTheirDisparities) {
  const NoiseModel noise{.floor_m = 0.0005, .growth_per_m = 0.0119, .from_m = 0};
  RecognisedSensor rig{SensorModel::kNone, "a rig"};
  rig.own_noise = noise;
  ScanObserver nobody;
  ScanSession session(nobody, {});
  ScanConfig config;
  config.fusion.voxel_size_m = 0.01;
  apply_sensor(rig, config, session);
  EXPECT_EQ(config.fusion.noise, noise);
  ASSERT_TRUE(config.acquire.max_depth_m);
  EXPECT_NEAR(*config.acquire.max_depth_m, noise.reach_m(0.05), 0.01) << "where the noise exceeds five voxels";

  ScanConfig stated;
  stated.acquire.sensor = SensorModel::kKinectV1;
  apply_sensor(rig, stated, session);
  EXPECT_NE(stated.fusion.noise, noise) << "what the user says wins";
}

/// A thing on a turntable, scanned from the same places by pairs and by structured light.
class StereoScan : public ::testing::Test {
 protected:
  static constexpr int kPoses = 24;
  static constexpr double kVoxel_m = 0.004;

  void SetUp() override {
    auto made = make_scene("turntable");
    ASSERT_TRUE(made);
    scene_ = *std::move(made);
  }
  /// The mesh of a recording, in the folder; its vertices' distances from the true surface, ascending.
  [[nodiscard]] std::vector<double> errors_m(const fs::path& recording, Geometry geometry, ScanResult& result) const {
    ScanJob job;
    job.input = recording;
    job.config.acquire.geometry = geometry;
    job.config.fusion.voxel_size_m = kVoxel_m;
    job.files.meshes = {folder_ / "out" / "model.ply"};
    ScanObserver nobody;
    result = scan_recording(job, nobody);
    EXPECT_TRUE(result.outcome) << result.outcome.error().text();
    const auto mesh = read_mesh(folder_ / "out" / "model.ply");
    if (!mesh) return {};
    std::vector<double> errors;
    for (const Eigen::Vector3f& p : mesh->positions_m) errors.push_back(scene_->surface_distance(p.cast<double>()));
    std::sort(errors.begin(), errors.end());
    return errors;
  }

  std::unique_ptr<SyntheticScene> scene_;
  TemporaryFolder folder_;
};

TEST_F(StereoScan, BecomesAMeshOfAFractionOfAVoxel) {
  const RigOnPaper rig;
  ASSERT_NO_FATAL_FAILURE(write_stereo_recording(*scene_, rig, camera_path(*scene_, kPoses), folder_ / "pairs"));
  SynthConfig kinect;
  kinect.frames = kPoses;
  kinect.intrinsics = rig.camera;
  kinect.noise = true;
  ASSERT_TRUE(write_synthetic_recording(*scene_, kinect, folder_ / "structured_light"));

  ScanResult of_pairs, of_light;
  const std::vector<double> stereo_m = errors_m(folder_ / "pairs", Geometry::kStereo, of_pairs);
  const std::vector<double> light_m = errors_m(folder_ / "structured_light", Geometry::kDepth, of_light);
  ASSERT_GT(stereo_m.size(), 1000u);
  ASSERT_GT(light_m.size(), 1000u);
  EXPECT_EQ(of_pairs.frames.fused, static_cast<std::size_t>(kPoses));
  const auto at = [](const std::vector<double>& errors, std::size_t percent) {
    return errors[errors.size() * percent / 100];
  };
  RecordProperty("stereo_median_um", static_cast<int>(1e6 * at(stereo_m, 50)));
  RecordProperty("structured_light_median_um", static_cast<int>(1e6 * at(light_m, 50)));
  fmt::print(
      "vertices off the surface, median and 95 %: stereo {:.2f} and {:.2f} mm, structured light {:.2f} and {:.2f} mm\n",
      1e3 * at(stereo_m, 50), 1e3 * at(stereo_m, 95), 1e3 * at(light_m, 50), 1e3 * at(light_m, 95));
  EXPECT_LT(at(stereo_m, 50), 0.25 * kVoxel_m);
  EXPECT_LT(at(stereo_m, 95), kVoxel_m);
}

}  // namespace
}  // namespace scanknit
