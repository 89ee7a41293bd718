#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

#include "synth/surface_error.h"
#include "tests/synth/test_synthetic_meshes.h"

namespace scanknit {
namespace {

using Eigen::Vector3d;

constexpr double kRadius_m = 0.1;
constexpr int kLevels = 4;

class SurfaceErrorOfASphere : public ::testing::Test {
 protected:
  [[nodiscard]] SurfaceError measure(const Mesh& mesh) const {
    const auto error = measure_surface(mesh, *scene_, truth_, {.area_samples = 20'000, .threshold_m = 0.002});
    EXPECT_TRUE(error) << (error ? "" : error.error().text());
    return error ? *error : SurfaceError{};
  }
  std::unique_ptr<SyntheticScene> scene_ = *make_scene("sphere");
  std::vector<TruthPoint> truth_ = sample_surface(*scene_, 5000, 1);
};

TEST_F(SurfaceErrorOfASphere, IsTheChordErrorForTheTrueMesh) {
  const SurfaceError error = measure(test::icosphere(kRadius_m, kLevels));
  constexpr double kFloat_m = 1e-8;
  EXPECT_LT(error.vertices.max_m, kFloat_m);
  EXPECT_LT(error.area.max_m, test::chord_error_m(kRadius_m, kLevels));
  EXPECT_GT(error.area.mean_m, 0.2 * test::chord_error_m(kRadius_m, kLevels));
  EXPECT_EQ(error.share_complete, 1);
}

TEST_F(SurfaceErrorOfASphere, IsHalfTheShiftOnAverage) {
  // A sphere shifted by s is off by s |cos|, whose mean over the sphere is s / 2 and whose largest value is s.
  constexpr double kShift_m = 0.001;
  const SurfaceError error = measure(test::icosphere(kRadius_m, kLevels, {0, kShift_m, 0}));
  const double tolerance = test::chord_error_m(kRadius_m, kLevels);
  EXPECT_NEAR(error.area.mean_m, kShift_m / 2, tolerance);
  EXPECT_NEAR(error.vertices.max_m, kShift_m, tolerance);
  EXPECT_NEAR(error.area.rms_m, kShift_m / std::sqrt(3.0), tolerance);
}

TEST_F(SurfaceErrorOfASphere, IsTheOffsetOfALargerSphere) {
  constexpr double kOffset_m = 0.001;
  const SurfaceError error = measure(test::icosphere(kRadius_m + kOffset_m, kLevels));
  EXPECT_NEAR(error.area.median_m, kOffset_m, test::chord_error_m(kRadius_m, kLevels));
  EXPECT_NEAR(error.completeness.mean_m, kOffset_m, test::chord_error_m(kRadius_m, kLevels));
}

TEST_F(SurfaceErrorOfASphere, FindsHalfASphereHalfComplete) {
  Mesh mesh = test::icosphere(kRadius_m, kLevels);
  std::erase_if(mesh.triangles, [&](const Triangle& t) {
    return mesh.positions_m[t[0]].y() + mesh.positions_m[t[1]].y() + mesh.positions_m[t[2]].y() < 0;
  });
  // The rim reaches one threshold (2 mm of 100 mm radius: 1 % of the area) and the statistics a few deviations farther.
  EXPECT_NEAR(measure(mesh).share_complete, 0.5, 0.04);
}

TEST_F(SurfaceErrorOfASphere, IsTheSameForAnyNumberOfThreads) {
  const Mesh mesh = test::icosphere(kRadius_m, kLevels, {0.001, 0, 0});
  const auto with_threads = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return measure(mesh);
  };
  const SurfaceError one = with_threads(1);
  const SurfaceError eight = with_threads(8);
  EXPECT_EQ(one.area.mean_m, eight.area.mean_m);
  EXPECT_EQ(one.completeness.rms_m, eight.completeness.rms_m);
}

TEST_F(SurfaceErrorOfASphere, RefusesMeshesThatCannotBeMeasured) {
  const auto code_of = [&](const Mesh& mesh) {
    const auto error = measure_surface(mesh, *scene_, truth_);
    return error ? ErrorCode::kInternal : error.error().code;
  };
  EXPECT_EQ(code_of({}), ErrorCode::kMesh);
  Mesh bad_index = test::icosphere(kRadius_m, 0);
  bad_index.triangles[3][1] = 12;
  EXPECT_EQ(code_of(bad_index), ErrorCode::kMesh);
  Mesh bad_number = test::icosphere(kRadius_m, 0);
  bad_number.positions_m[3].z() = INFINITY;
  EXPECT_EQ(code_of(bad_number), ErrorCode::kMesh);
  Mesh no_area;
  no_area.positions_m.assign(3, Eigen::Vector3f::Zero());
  no_area.triangles = {{0, 1, 2}};
  EXPECT_EQ(code_of(no_area), ErrorCode::kMesh);
}

TEST_F(SurfaceErrorOfASphere, BearsDegenerateTriangles) {
  Mesh mesh = test::icosphere(kRadius_m, kLevels);
  mesh.triangles.push_back({0, 0, 1});
  mesh.triangles.push_back({5, 5, 5});
  EXPECT_EQ(measure(mesh).share_complete, 1);
}

}  // namespace
}  // namespace scanknit
