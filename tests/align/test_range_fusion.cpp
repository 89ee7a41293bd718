// Range scans become surfaces, and enter the volume along their lines of sight.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <numbers>

#include "fusion/range/range_integrate.h"
#include "fusion/range/range_surface.h"
#include "fusion/range/range_view.h"

namespace scanknit {
namespace {

constexpr double kRadius_m = 0.03;
constexpr double kVoxel_m = 0.001;

/// A ball of kRadius_m at the origin before a wall at z = -0.1, by parallel lines along -z, `step_m` apart.
RangeScan parallel_scan(double step_m = 0.0005) {
  constexpr int kSide = 200;
  RangeScan scan;
  scan.points_m = Image<Eigen::Vector3f>(kSide, kSide, kNoReturn);
  scan.sight = {.kind = SightLines::Kind::kTwoSlits};
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const double px = (x - 0.5 * (kSide - 1)) * step_m;
      const double py = (0.5 * (kSide - 1) - y) * step_m;
      const double inside = kRadius_m * kRadius_m - px * px - py * py;
      scan.points_m.at(x, y) = Eigen::Vector3d(px, py, inside > 0 ? std::sqrt(inside) : -0.1).cast<float>();
    }
  }
  return scan;
}

/// The ball from all round: from a centre inside of a hollow ball, columns of longitude, as terrestrial scanners look.
RangeScan round_scan() {
  constexpr int kColumns = 360, kRows = 120;
  RangeScan scan;
  scan.points_m = Image<Eigen::Vector3f>(kColumns, kRows, kNoReturn);
  scan.sight = {.kind = SightLines::Kind::kSphere, .pole = 2};
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x < kColumns; ++x) {
      const double azimuth = 2 * std::numbers::pi * x / kColumns - std::numbers::pi;
      const double elevation = (60 - y) * std::numbers::pi / 180;
      scan.points_m.at(x, y) =
          (kRadius_m * Eigen::Vector3d(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                                       std::sin(elevation)))
              .cast<float>();
    }
  }
  return scan;
}

TsdfVolume volume_of_1mm() {
  FusionConfig config;
  config.voxel_size_m = kVoxel_m;
  auto volume = TsdfVolume::create(config);
  EXPECT_TRUE(volume);
  return *std::move(volume);
}

TEST(RangeSurface, IsCutWhereDepthSteps) {
  const RangeScan scan = parallel_scan();
  const RangeSurface surface = find_surface(scan);
  ASSERT_FALSE(surface.triangles.empty());
  for (const Triangle& t : surface.triangles) {
    const bool first_on_ball = scan.points_m.pixels()[t[0]].z() > -0.05f;
    for (const std::uint32_t corner : t) EXPECT_EQ(scan.points_m.pixels()[corner].z() > -0.05f, first_on_ball);
  }
  EXPECT_NEAR(surface.spacing_m, 0.0005, 1e-5);
}

TEST(RangeSurface, NormalsPointToTheScanner) {
  const RangeScan scan = parallel_scan();
  const RangeSurface surface = find_surface(scan);
  EXPECT_GT(surface.normals.at(100, 100).z(), 0.99f);
  const Eigen::Vector3f p = scan.points_m.at(130, 100);
  EXPECT_GT(surface.normals.at(130, 100).dot(p.normalized()), 0.999f);
  EXPECT_EQ(surface.inset.at(100, 100), RangeSurface::kDeepest);
}

TEST(RangeView, StrayPointsNeitherStretchNorFillIt) {
  RangeScan scan = parallel_scan();
  const RangeView clean(scan, find_surface(scan));
  scan.points_m.at(3, 4) = {1e30f, -1e30f, 0};
  scan.points_m.at(9, 7) = {0, 1e30f, 1e30f};
  scan.points_m.at(195, 190) = {500, -300, 0};
  const RangeView stray(scan, find_surface(scan));
  EXPECT_LE(stray.pixels().width(), 3 * clean.pixels().width());
  EXPECT_LE(stray.pixels().height(), 3 * clean.pixels().height());
  const Eigen::Vector3d before_ball(0.01, 0.01, 0.05);
  const auto there = stray.front_of(before_ball), expected = clean.front_of(before_ball);
  ASSERT_TRUE(there && expected);
  EXPECT_NEAR(there->before_m, expected->before_m, 1e-4);
}

TEST(RangeIntegrate, ABallComesOutAtItsRadius) {
  const RangeScan scan = parallel_scan();
  const RangeSurface surface = find_surface(scan);
  TsdfVolume volume = volume_of_1mm();
  Pose T_world_scan = Pose::Identity();
  T_world_scan.translation() = Eigen::Vector3d(0.5, -0.2, 0.1);
  ASSERT_TRUE(integrate(RangeView(scan, surface), surface.noise_m, T_world_scan, volume));
  std::size_t checked = 0;
  for (auto it = volume.tsdf().cbeginValueOn(); it; ++it) {
    const Eigen::Vector3d p = Eigen::Vector3d(it.getCoord().x(), it.getCoord().y(), it.getCoord().z()) * kVoxel_m -
                              T_world_scan.translation();
    const double truth = p.norm() - kRadius_m;
    if (p.z() < 0.7 * kRadius_m || std::abs(truth) > kVoxel_m) continue;  // planes leave a ball beside it
    EXPECT_NEAR(*it, truth, 0.0001) << p.transpose();
    ++checked;
  }
  EXPECT_GT(checked, 1000u);
}

TEST(RangeIntegrate, ARoundScanHasNoSeam) {
  const RangeScan scan = round_scan();
  const RangeSurface surface = find_surface(scan);
  TsdfVolume volume = volume_of_1mm();
  ASSERT_TRUE(integrate(RangeView(scan, surface), surface.noise_m, Pose::Identity(), volume));
  for (int degree = -180; degree < 180; ++degree) {  // the surface is seen from inside: free space is within
    const double angle = degree * std::numbers::pi / 180;
    const auto at = [&](double radius) {
      return volume.voxel(
          openvdb::Coord::round(openvdb::Vec3d(std::cos(angle), std::sin(angle), 0) * (radius / kVoxel_m)));
    };
    EXPECT_GT(at(kRadius_m - 0.0015).weight, 0) << degree;
    EXPECT_GT(at(kRadius_m - 0.0015).tsdf_m, 0) << degree;
    EXPECT_LT(at(kRadius_m + 0.0015).tsdf_m, 0) << degree;
  }
}

TEST(RangeIntegrate, TheUnseenBackStaysUnknown) {
  const RangeScan scan = parallel_scan();
  const RangeSurface surface = find_surface(scan);
  TsdfVolume volume = volume_of_1mm();
  ASSERT_TRUE(integrate(RangeView(scan, surface), surface.noise_m, Pose::Identity(), volume));
  EXPECT_EQ(volume.voxel({0, 0, 0}).weight, 0);
  EXPECT_EQ(volume.voxel({0, 0, -30}).weight, 0);
  EXPECT_GT(volume.voxel({0, 0, 30}).weight, 0);
}

TEST(RangeIntegrate, GivesTheSameBitsForAnyNumberOfThreads) {
  const RangeScan scan = parallel_scan();
  const RangeSurface surface = find_surface(scan);
  const auto fused = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    TsdfVolume volume = volume_of_1mm();
    EXPECT_TRUE(integrate(RangeView(scan, surface), surface.noise_m, Pose::Identity(), volume));
    EXPECT_TRUE(integrate(RangeView(scan, surface), surface.noise_m,
                          Pose(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitY())), volume));
    std::vector<std::pair<openvdb::Coord, float>> values;
    for (auto it = volume.tsdf().cbeginValueOn(); it; ++it) values.emplace_back(it.getCoord(), *it);
    return values;
  };
  const auto one = fused(1);
  EXPECT_GT(one.size(), 10'000u);
  EXPECT_EQ(one, fused(2));
  EXPECT_EQ(one, fused(8));
}

TEST(RangeIntegrate, StopsGrowingAtTheBudget) {
  const RangeScan scan = parallel_scan(0.005);  // a metre
  const RangeSurface surface = find_surface(scan);
  FusionConfig config;
  config.voxel_size_m = 0.0005;
  config.memory_budget_mib = 16;
  auto volume = TsdfVolume::create(config);
  ASSERT_TRUE(volume);
  const auto stats = integrate(RangeView(scan, surface), surface.noise_m, Pose::Identity(), *volume);
  ASSERT_TRUE(stats);
  EXPECT_TRUE(stats->is_budget_reached);
  EXPECT_LE(volume->memory_bytes(), std::size_t{16} << 20);
}

}  // namespace
}  // namespace scanknit
