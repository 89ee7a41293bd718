// A mesh from depth whose gaps the masks' silhouettes fill.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <string>
#include <vector>

#include "export/mesh/read_mesh.h"
#include "scan/scan.h"
#include "synth/render.h"
#include "synth/scene/scene.h"
#include "synth/sensor/sensor_keys.h"
#include "synth/write_recording.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

using Points = std::vector<Eigen::Vector3f>;

bool is_before(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
}

Points sorted(Points points) {
  std::sort(points.begin(), points.end(), is_before);
  return points;
}

/// Those of `a` that are not among `b`; both sorted.
Points not_among(const Points& a, const Points& b) {
  Points rest;
  std::set_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(rest), is_before);
  return rest;
}

/// Beyond the wall of the cup, whose axis is y.
auto count_on_handle(const Points& points) {
  return std::count_if(points.begin(), points.end(),
                       [](const Eigen::Vector3f& p) { return p.x() > 0.045f && std::abs(p.z()) < 0.012f; });
}

/// A cup, whose handle gives no depth.
class CarveGaps : public ::testing::Test {
 protected:
  static constexpr double kCupVoxel_m = 0.003;

  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("scanknit_carve_gaps_" + std::to_string(::getpid()));
    SynthConfig config;
    config.frames = 40;
    config.intrinsics = {320, 240, 262.5, 262.5, 159.5, 119.5};
    config.masks = true;
    auto sensor = make_sensor("ideal");
    ASSERT_TRUE(sensor) << sensor.error().text();
    ASSERT_TRUE(set_sensor_value(*sensor, "returns.dark=5%"));
    config.sensor = *sensor;
    const auto scene = make_scene("cup");
    ASSERT_TRUE(scene) << scene.error().text();
    ASSERT_TRUE(write_synthetic_recording(**scene, config, recording()));
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] fs::path recording() const { return folder_ / "cup"; }
  [[nodiscard]] ScanJob job(SilhouetteUse use) const {
    ScanJob job;
    job.input = recording();
    job.config.acquire.masks = "masks";
    job.config.fusion.voxel_size_m = kCupVoxel_m;
    job.config.fusion.silhouettes = use;
    job.files.meshes = {folder_ / "model.ply"};
    return job;
  }
  [[nodiscard]] static ScanResult scanned(const ScanJob& asked) {
    ScanObserver nobody;
    return scan_recording(asked, nobody);
  }
  [[nodiscard]] Points vertices() const {
    const auto mesh = read_mesh(folder_ / "model.ply");
    EXPECT_TRUE(mesh) << mesh.error().text();
    return mesh ? sorted(mesh->positions_m) : Points();
  }

 private:
  fs::path folder_;
};

TEST_F(CarveGaps, AHandleWithoutDepthAppearsAndTheRestStays) {
  ASSERT_TRUE(scanned(job(SilhouetteUse::kOff)).outcome);
  const Points by_depth = vertices();
  const ScanResult result = scanned(job(SilhouetteUse::kCarve));
  ASSERT_TRUE(result.outcome) << result.outcome.error().text();
  const Points carved = vertices();
  EXPECT_EQ(count_on_handle(by_depth), 0);
  EXPECT_GT(count_on_handle(carved), 300);

  const Points filled = not_among(carved, by_depth);
  for (const Eigen::Vector3f& lost : not_among(by_depth, carved)) {
    const bool is_near = std::any_of(filled.begin(), filled.end(), [&](const Eigen::Vector3f& p) {
      return (p - lost).norm() < 4 * static_cast<float>(kCupVoxel_m);
    });
    ASSERT_TRUE(is_near) << lost.transpose();
  }
  ASSERT_TRUE(result.silhouettes);
  EXPECT_EQ(result.silhouettes->pictures, 40u);
  EXPECT_GT(result.silhouettes->agreement, 0.99);
}

TEST_F(CarveGaps, WithoutMasksSaysWhatToSet) {
  ScanJob asked = job(SilhouetteUse::kCarve);
  asked.config.acquire.masks.reset();
  const ScanResult result = scanned(asked);
  ASSERT_FALSE(result.outcome);
  EXPECT_EQ(result.outcome.error().code, ErrorCode::kConfig);
  EXPECT_NE(result.outcome.error().text().find("acquire.masks"), std::string::npos);
  EXPECT_NE(result.outcome.error().text().find("acquire.background"), std::string::npos);
}

}  // namespace
}  // namespace scanknit
