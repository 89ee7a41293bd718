// Holes of a mesh, and a mesh against depth frames.
#include <gtest/gtest.h>

#include <numbers>

#include "export/measure/holes.h"
#include "export/picture/surface_fit.h"
#include "tests/export/export_samples.h"

namespace scanknit {
namespace {

constexpr double kRounding = 1e-5;

TEST(Holes, AClosedMeshHasNone) {
  EXPECT_TRUE(find_holes(test::torus()).empty());
}

TEST(Holes, AMissingTriangleIsOneOfItsCircumference) {
  Mesh mesh = test::cube();
  mesh.triangles.pop_back();
  const auto holes = find_holes(mesh);
  ASSERT_EQ(holes.size(), 1u);
  EXPECT_EQ(holes[0].edges, 3u);
  EXPECT_NEAR(holes[0].length_m, 2 + 2 + 2 * std::numbers::sqrt2, kRounding);
}

TEST(Holes, TwoAreToldLongestFirst) {
  Mesh mesh = test::cube();
  mesh.triangles.pop_back();
  Mesh with_side_missing = test::cube();
  const auto is_low = [&](const Triangle& t) {
    return std::all_of(t.begin(), t.end(), [&](std::uint32_t v) {
      return with_side_missing.positions_m[v].z() == test::cube().positions_m[0].z();
    });
  };
  ASSERT_EQ(std::erase_if(with_side_missing.triangles, is_low), 2u);
  const auto first = static_cast<std::uint32_t>(mesh.positions_m.size());
  for (const Eigen::Vector3f& p : with_side_missing.positions_m) mesh.positions_m.push_back(p);
  for (const Triangle& t : with_side_missing.triangles)
    mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  const auto holes = find_holes(mesh);
  ASSERT_EQ(holes.size(), 2u);
  EXPECT_EQ(holes[0].edges, 4u);  // a side
  EXPECT_NEAR(holes[0].length_m, 8, kRounding);
  EXPECT_EQ(holes[1].edges, 3u);
  EXPECT_NEAR(holes[1].length_m, 4 + 2 * std::numbers::sqrt2, kRounding);
}

TEST(Holes, TheBorderOfAnOpenSurfaceIsOne) {
  Mesh square;
  square.positions_m = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  square.triangles = {{0, 1, 2}, {0, 2, 3}};
  const auto holes = find_holes(square);
  ASSERT_EQ(holes.size(), 1u);
  EXPECT_NEAR(holes[0].length_m, 4, kRounding);
}

TEST(Holes, OfTrianglesThatRunAgainstEachOtherComeToAnEnd) {
  Mesh mesh = test::cube();
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) std::swap(mesh.triangles[i][0], mesh.triangles[i][1]);
  mesh.triangles.pop_back();
  std::size_t edges = 0;
  for (const Hole& hole : find_holes(mesh)) edges += hole.edges;
  EXPECT_EQ(edges, check_mesh(mesh).boundary_edges);
}

/// A wall at depth 1, seen by a camera at the origin, in patches of 5 cm.
constexpr int kSide = 21;
Mesh wall(float depth_m = 1) {
  Mesh mesh;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      mesh.positions_m.emplace_back(0.05f * static_cast<float>(x - kSide / 2),
                                    0.05f * static_cast<float>(y - kSide / 2), depth_m);
      mesh.normals.emplace_back(0, 0, -1);
    }
  }
  for (std::uint32_t y = 0; y + 1 < kSide; ++y) {
    for (std::uint32_t x = 0; x + 1 < kSide; ++x) {
      const std::uint32_t i = y * kSide + x;
      mesh.triangles.push_back({i, i + kSide, i + 1});
      mesh.triangles.push_back({i + 1, i + kSide, i + kSide + 1});
    }
  }
  return mesh;
}

const CameraIntrinsics kCamera{160, 120, 100, 100, 79.5, 59.5};
const FitBand kBand{0.05, 0, {}};

TEST(SurfaceFit, AWallThatIsNearerThanItsPictureIsOffByThat) {
  const DepthImage depth(160, 120, 1.0125f);
  const std::vector<PosedDepth> frames = {{&depth, kCamera, Pose::Identity()}};
  const SurfaceFit fit = fit_surface(wall(), frames, kBand);
  EXPECT_NEAR(fit.median_m, 0.0125, kRounding);
  EXPECT_NEAR(fit.p95_m, 0.0125, kRounding);
  EXPECT_EQ(fit.seen_share, 1);  // 1 m of the 1.6 m and 1.2 m that the camera sees
  EXPECT_EQ(coverage_map_end(fit), 1u);
  EXPECT_NEAR(error_map_end_m(fit), 0.02, kRounding);
}

TEST(SurfaceFit, ASlantedWallFitsItselfExactly) {
  Mesh slanted = wall();
  const float slope = 0.5f;
  for (std::size_t i = 0; i < slanted.positions_m.size(); ++i) {
    slanted.positions_m[i].z() = 1 + slope * slanted.positions_m[i].x();
    slanted.normals[i] = Eigen::Vector3f(slope, 0, -1).normalized();
  }
  DepthImage depth(160, 120);
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      const double ray_x = (x - kCamera.cx) / kCamera.fx;  // z = 1 + slope x, x = ray_x z
      depth.at(x, y) = static_cast<float>(1 / (1 - slope * ray_x));
    }
  }
  const std::vector<PosedDepth> frames = {{&depth, kCamera, Pose::Identity()}};
  const SurfaceFit fit = fit_surface(slanted, frames, kBand);
  EXPECT_GT(fit.seen_share, 0.9);
  EXPECT_LT(fit.p95_m, 1e-6);
}

TEST(SurfaceFit, WhatIsBehindSomethingOrSeenFromBehindIsNotSeen) {
  const DepthImage near(160, 120, 0.5f), right(160, 120, 1.0f), nothing(160, 120, 0.0f);
  Pose beyond = Pose::Identity();
  beyond.linear() = Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitY()).toRotationMatrix();
  beyond.translation() = Eigen::Vector3d(0, 0, 2);
  const std::vector<PosedDepth> frames = {
      {&near, kCamera, Pose::Identity()}, {&right, kCamera, beyond}, {&nothing, kCamera, Pose::Identity()}};
  const SurfaceFit fit = fit_surface(wall(), frames, kBand);
  EXPECT_EQ(fit.seen_share, 0);
  EXPECT_EQ(fit.median_m, 0);
  EXPECT_GT(error_map_end_m(fit), 0);
}

TEST(SurfaceFit, CountsTheFramesThatSeeEachPlace) {
  const DepthImage depth(160, 120, 1.0f);
  Pose aside = Pose::Identity();
  aside.translation() = Eigen::Vector3d(1, 0, 0);  // sees x from 0.2 on
  const std::vector<PosedDepth> frames = {{&depth, kCamera, Pose::Identity()}, {&depth, kCamera, aside}};
  const SurfaceFit fit = fit_surface(wall(), frames, kBand);
  EXPECT_EQ(fit.seen_by.front(), 1);  // the left
  EXPECT_EQ(fit.seen_by.back(), 2);
}

TEST(SurfaceFit, MapsShowErrorsAndWhatWasNotSeen) {
  DepthImage depth(160, 120, 1.0f);
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 80; ++x) depth.at(x, y) = 0;
  }
  const Mesh mesh = wall();
  const std::vector<PosedDepth> frames = {{&depth, kCamera, Pose::Identity()}};
  const SurfaceFit fit = fit_surface(mesh, frames, kBand);
  EXPECT_NEAR(fit.seen_share, 0.5, 0.05);
  const ColourImage map = draw_error_map(mesh, fit, UpAxis::kMinusY, Pose::Identity());
  const Rgb8 left = map.at(map.width() / 8, map.height() / 2), right = map.at(3 * map.width() / 8, map.height() / 2);
  EXPECT_LE(std::abs(left.r - left.b), 10) << "unseen is grey";
  EXPECT_GT(right.b, right.r + 40) << "no error is blue";
}

}  // namespace
}  // namespace scanknit
