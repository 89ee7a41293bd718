// One mesh for each class of the masks: three solids that touch a table, with masks as wrong at their rims as real
// ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include "acquire/convert/picture_files.h"
#include "core/mesh/mesh_area.h"
#include "export/mesh/read_mesh.h"
#include "scan/scan.h"
#include "tests/core/temporary_folder.h"
#include "tests/fusion/small_world.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;

constexpr double kVoxel = 0.005;
constexpr int kFrames = 24;
constexpr CameraIntrinsics kCamera{240, 180, 200, 200, 119.5, 89.5};  // a pixel is 4 mm at 0.8 m

struct Solid {
  Eigen::Vector3d centre;
  double radius_m;
  [[nodiscard]] double distance_m(const Eigen::Vector3d& p) const { return std::abs((p - centre).norm() - radius_m); }
};

/// The table is z = 0: each ball is sunk into it a little, and the first two touch.
const std::array<Solid, 3> kSolids = {{{{0.1, 0, 0.06}, 0.08}, {{-0.06, 0, 0.06}, 0.08}, {{0.0, 0.16, 0.05}, 0.06}}};
constexpr std::array<std::uint8_t, 3> kLabels = {3, 7, 200};

World table_with_solids() {
  World world = World().add_wall({0, 0, 1}, 0);
  for (const Solid& solid : kSolids) world.add_ball(solid.centre, solid.radius_m);
  return world;
}

Pose pose_of_frame(int frame) {
  const double angle = 2 * kPi * frame / kFrames;
  const double height = frame % 2 == 0 ? 0.4 : 0.6;
  return looking_at_origin({0.65 * std::cos(angle), 0.65 * std::sin(angle), height});
}

/// 0: the table.
std::uint8_t label_at(const Eigen::Vector3d& p_world) {
  constexpr double kRounding = 1e-5;  // of depth as float
  for (std::size_t i = 0; i < kSolids.size(); ++i) {
    if (kSolids[i].distance_m(p_world) < kRounding) return kLabels[i];
  }
  return 0;
}

ColourImage labels_of(const Frame& frame, const Pose& T_world_camera) {
  ColourImage labels(kCamera.width, kCamera.height);
  for (int y = 0; y < kCamera.height; ++y) {
    for (int x = 0; x < kCamera.width; ++x) {
      const double z = static_cast<double>(frame.depth_m.at(x, y));
      const std::uint8_t label = z > 0 ? label_at(T_world_camera * kCamera.unproject(x, y, z)) : std::uint8_t{0};
      labels.at(x, y) = {label, label, label};
    }
  }
  return labels;
}

/// Grows all labels by a pixel, into what has none; or shrinks them.
ColourImage with_moved_rims(const ColourImage& labels, bool grows) {
  ColourImage moved = labels;
  for (int y = 0; y < labels.height(); ++y) {
    for (int x = 0; x < labels.width(); ++x) {
      for (const auto& [dx, dy] : {std::array{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
        if (!labels.contains(x + dx, y + dy)) continue;
        const Rgb8 beside = labels.at(x + dx, y + dy);
        const bool changes = grows ? labels.at(x, y).r == 0 && beside.r != 0 : beside != labels.at(x, y);
        if (changes) moved.at(x, y) = grows ? beside : Rgb8{};
      }
    }
  }
  return moved;
}

/// `rim`: pixels by which the masks are too large in odd frames, and too small in even ones.
void write_recording(const fs::path& folder, int rim, bool has_poses = true) {
  for (const char* name : {"depth", "color", "masks"}) fs::create_directories(folder / name);
  const World world = table_with_solids();
  std::string log;
  for (int i = 0; i < kFrames; ++i) {
    const Pose pose = pose_of_frame(i);
    const Frame frame = look(world, pose, /*has_colour=*/true, kCamera);
    ColourImage labels = labels_of(frame, pose);
    for (int n = 0; n < rim; ++n) labels = with_moved_rims(labels, i % 2 == 1);
    const std::string name = std::to_string(1000 + i) + ".png";
    ASSERT_TRUE(write_depth_png(to_raw_depth(frame.depth_m, 10'000), folder / "depth" / name));
    ASSERT_TRUE(write_colour_png(frame.colour->image, folder / "color" / name));
    ASSERT_TRUE(write_colour_png(labels, folder / "masks" / name));
    append_log_pose(log, static_cast<std::size_t>(i), pose.matrix());
  }
  ASSERT_TRUE(write_camera_json(kCamera, 10'000, folder / "camera_intrinsic.json"));
  if (has_poses) std::ofstream(folder / "trajectory.log") << log;
}

class Classes : public ::testing::Test {
 protected:
  [[nodiscard]] ScanJob job() const {
    ScanJob job;
    job.input = folder_ / "recording";
    job.config.fusion.voxel_size_m = kVoxel;
    job.config.acquire.masks = "masks";
    job.meshes_each_class = true;
    job.files.meshes = {mesh()};
    return job;
  }
  [[nodiscard]] fs::path mesh() const { return folder_ / "model.ply"; }
  [[nodiscard]] fs::path mesh_of(int label) const { return folder_ / ("model_class" + std::to_string(label) + ".ply"); }
  [[nodiscard]] static ScanResult scan(const ScanJob& job) {
    ScanObserver observer;
    return scan_recording(job, observer);
  }
  void record(int rim) const { ASSERT_NO_FATAL_FAILURE(write_recording(folder_ / "recording", rim)); }

  /// The mesh of one solid has nothing of its neighbours, and not much is missing.
  void expect_alone(std::size_t i) const {
    const auto read = read_mesh(mesh_of(kLabels[i]));
    ASSERT_TRUE(read) << read.error().text();
    const Solid& solid = kSolids[i];
    double farthest_m = 0, sum_m = 0, top_m = 0;
    for (const Eigen::Vector3f& p : read->positions_m) {
      const double off_m = solid.distance_m(p.cast<double>());
      farthest_m = std::max(farthest_m, off_m);
      sum_m += off_m;
      top_m = std::max(top_m, static_cast<double>(p.z()));
    }
    const double mean_m = sum_m / static_cast<double>(read->positions_m.size());
    const double seen_m2 = 2 * kPi * solid.radius_m * (solid.radius_m + solid.centre.z());
    double area_m2 = 0;
    for (const auto& t : read->triangles) {
      const auto at = [&](std::size_t n) { return read->positions_m[t[n]].cast<double>().eval(); };
      area_m2 += 0.5 * (at(1) - at(0)).cross(at(2) - at(0)).norm();
    }
    std::cout << "class " << int{kLabels[i]} << ": farthest " << 1000 * farthest_m << " mm, mean " << 1000 * mean_m
              << " mm, area " << 100 * area_m2 / seen_m2 << " %\n";
    EXPECT_LE(farthest_m, 2 * kVoxel);
    EXPECT_LE(mean_m, 0.2 * kVoxel);
    EXPECT_NEAR(top_m, solid.centre.z() + solid.radius_m, kVoxel);
    EXPECT_GE(area_m2, 0.6 * seen_m2);  // feet are hidden by neighbours
    EXPECT_LE(area_m2, 1.1 * seen_m2);
  }

 private:
  TemporaryFolder folder_;
};

class ClassesWithWrongRims : public Classes, public ::testing::WithParamInterface<int> {};

TEST_P(ClassesWithWrongRims, HaveNothingOfTheirNeighbours) {
  ASSERT_NO_FATAL_FAILURE(record(GetParam()));
  for (const MaskMeans means : {MaskMeans::kUnknown, MaskMeans::kFree}) {
    ScanJob asked = job();
    asked.config.acquire.mask_means = means;
    const ScanResult result = scan(asked);
    ASSERT_TRUE(result.outcome) << result.outcome.error().text();
    EXPECT_EQ(result.frames.fused, static_cast<std::size_t>(kFrames));
    ASSERT_EQ(result.classes.size(), kSolids.size());
    for (std::size_t i = 0; i < kSolids.size(); ++i) {
      EXPECT_EQ(result.classes[i].label, kLabels[i]);
      EXPECT_EQ(result.files.at("ply_class" + std::to_string(kLabels[i])), mesh_of(kLabels[i]).string());
      expect_alone(i);
      const auto written = read_mesh(mesh_of(kLabels[i]));
      ASSERT_TRUE(written && result.classes[i].area_m2);
      EXPECT_NEAR(*result.classes[i].area_m2, area_m2(*written), 1e-6);
    }
    EXPECT_FALSE(fs::exists(mesh()));
  }
}

INSTANTIATE_TEST_SUITE_P(Pixels, ClassesWithWrongRims, ::testing::Values(0, 1, 2), ::testing::PrintToStringParamName());

TEST_F(Classes, AreAsGoodAsEachAlone) {
  ASSERT_NO_FATAL_FAILURE(record(1));
  ASSERT_TRUE(scan(job()).outcome);
  ScanJob alone = job();
  alone.meshes_each_class = false;
  alone.config.acquire.mask_class = kLabels[1];
  const auto of_all = read_mesh(mesh_of(kLabels[1]));
  alone.files.meshes = {mesh_of(kLabels[1])};
  const ScanResult result = scan(alone);
  ASSERT_TRUE(result.outcome) << result.outcome.error().text();
  const auto one = read_mesh(mesh_of(kLabels[1]));
  ASSERT_TRUE(one && of_all);
  expect_alone(1);
  // At rims the normals and the filter of a class among others know the depth beside it.
  const auto vertices = static_cast<double>(one->positions_m.size());
  EXPECT_NEAR(static_cast<double>(of_all->positions_m.size()), vertices, 0.05 * vertices);
}

TEST_F(Classes, NeedMasks) {
  ASSERT_NO_FATAL_FAILURE(record(0));
  ScanJob without = job();
  without.config.acquire.masks.reset();
  const ScanResult result = scan(without);
  ASSERT_FALSE(result.outcome);
  EXPECT_EQ(result.outcome.error().code, ErrorCode::kUsage);
}

TEST_F(Classes, ShareTheMemoryBudget) {
  ASSERT_NO_FATAL_FAILURE(record(0));
  ScanJob small = job();
  small.config.fusion.memory_budget_mib = 183;  // of which the volumes get 60
  small.config.fusion.voxel_size_m = 0.0006;    // each alone would fit
  const ScanResult result = scan(small);
  ASSERT_TRUE(result.outcome) << result.outcome.error().text();
  EXPECT_TRUE(result.volume.is_budget_reached);
  EXPECT_LE(result.volume.memory_mib, 65);
  EXPECT_NE(find_warning(result, WarningCode::kBudgetReached), nullptr);
}

TEST_F(Classes, OfMasksWithoutAnyAreAnError) {
  ASSERT_NO_FATAL_FAILURE(record(0));
  for (int i = 0; i < kFrames; ++i) {
    ASSERT_TRUE(write_colour_png(ColourImage(kCamera.width, kCamera.height),
                                 job().input / "masks" / (std::to_string(1000 + i) + ".png")));
  }
  const ScanResult result = scan(job());
  ASSERT_FALSE(result.outcome);
  EXPECT_EQ(result.outcome.error().code, ErrorCode::kMesh);
}

}  // namespace
}  // namespace scanknit::test
