// Scans with holes become closed, and what was seen stays where it was.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <iostream>
#include <set>
#include <tuple>

#include "finish/invented.h"
#include "finish/smallest_surface.h"
#include "finish/voxel_set.h"
#include "tests/finish/scanned_field.h"

namespace scanknit {
namespace {

using test::kVoxel;

struct Closed {
  Mesh open, mesh;
  std::vector<std::uint8_t> invented;
};

Closed close(const openvdb::FloatGrid& grid, bool is_outside_free = true) {
  Closed closed;
  closed.open = test::mesh_of(grid);
  CloseRequest request = test::all_of(closed.open);
  request.is_outside_free = is_outside_free;
  const auto volume = close_volume(test::view_of(grid), request);
  EXPECT_TRUE(volume);
  if (!volume) return closed;
  closed.mesh = test::mesh_of(*volume->field);
  closed.invented = invented_triangles(closed.mesh, *volume);
  return closed;
}

using Place = std::tuple<float, float, float>;
std::set<Place> places(const Mesh& mesh) {
  std::set<Place> found;
  for (const auto& p : mesh.positions_m) found.emplace(p.x(), p.y(), p.z());
  return found;
}

std::size_t moved(const Closed& closed) {
  const auto now = places(closed.mesh);
  std::size_t count = 0;
  for (const Place& place : places(closed.open)) count += now.contains(place) ? 0 : 1;
  return count;
}

void expect_closed(const Mesh& mesh, long long euler) {
  const MeshCheck check = check_mesh(mesh);
  EXPECT_TRUE(check.is_closed()) << check.boundary_edges;
  EXPECT_TRUE(check.is_manifold());
  EXPECT_EQ(check.components, 1u);
  EXPECT_EQ(check.euler, euler);
  EXPECT_EQ(check.degenerate_triangles, 0u);
}

// A ball without the lowest third, and with a round patch of its side missing.
TEST(CloseVolume, ABallWithoutUndersideAndWithAMissingPatchIsABallAgain) {
  const Eigen::Vector3d patch(0.07, 0, 0.03);
  const auto grid = test::scan_of(
      test::ball(0.08), [&](const Eigen::Vector3d& p) { return p.z() > -0.03 && (p - patch).norm() > 0.025; });
  const Closed closed = close(*grid);
  EXPECT_FALSE(check_mesh(closed.open).is_closed());
  expect_closed(closed.mesh, 2);
  EXPECT_EQ(moved(closed), 0u);
  // The smallest cap is the disc at z = -0.03; the patch's disc is 25 mm round.
  const double disc_m2 = 3.14159 * (0.08 * 0.08 - 0.03 * 0.03);
  const double patch_m2 = 3.14159 * 0.025 * 0.025;
  const double invented_m2 = area_m2(closed.mesh, closed.invented);
  std::cout << "invented " << 1e6 * invented_m2 << " mm2, discs " << 1e6 * (disc_m2 + patch_m2) << " mm2\n";
  EXPECT_NEAR(invented_m2, disc_m2 + patch_m2, 0.15 * (disc_m2 + patch_m2));
}

TEST(CloseVolume, AWideOpeningIsClosedByAFlatCap) {
  const auto grid =
      test::scan_of(test::block({0.08, 0.06, 0.05}), [](const Eigen::Vector3d& p) { return p.z() > -0.04; });
  const Closed closed = close(*grid);
  expect_closed(closed.mesh, 2);
  EXPECT_EQ(moved(closed), 0u);
  double lowest = 0;
  double highest_of_cap = -1;
  for (std::size_t i = 0; i < closed.invented.size(); ++i) {
    if (closed.invented[i] == 0) continue;
    for (const auto v : closed.mesh.triangles[i]) {
      const double z = static_cast<double>(closed.mesh.positions_m[v].z());
      lowest = std::min(lowest, z);
      highest_of_cap = std::max(highest_of_cap, z);
    }
  }
  std::cout << "the cap lies between " << lowest << " and " << highest_of_cap << " m, the rim at -0.04\n";
  EXPECT_GT(lowest, -0.04 - 2 * kVoxel);
  EXPECT_LT(highest_of_cap, -0.04 + 2 * kVoxel);
}

TEST(CloseVolume, ARingKeepsItsHole) {
  const auto grid = test::scan_of(test::ring(0.07, 0.025), [](const Eigen::Vector3d& p) { return p.z() > -0.012; });
  const Closed closed = close(*grid);
  expect_closed(closed.mesh, 0);
  EXPECT_EQ(moved(closed), 0u);
}

TEST(CloseVolume, WhatIsClosedAlreadyStaysAsItIs) {
  const auto grid = test::scan_of(test::ball(0.06), [](const Eigen::Vector3d&) { return true; });
  const Closed closed = close(*grid);
  EXPECT_EQ(moved(closed), 0u);
  EXPECT_EQ(closed.mesh.triangles.size(), closed.open.triangles.size());
  EXPECT_EQ(area_m2(closed.mesh, closed.invented), 0);
}

TEST(CloseVolume, IsTheSameBitsForOneTwoAndEightThreads) {
  const auto grid = test::scan_of(test::ball(0.07), [](const Eigen::Vector3d& p) { return p.z() > -0.02; });
  std::vector<Closed> closed;
  for (const std::size_t threads : {1, 2, 8}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    closed.push_back(close(*grid));
  }
  for (const Closed& other : closed) {
    EXPECT_TRUE(other.mesh.positions_m == closed[0].mesh.positions_m);
    EXPECT_EQ(other.invented, closed[0].invented);
  }
}

// A sheet with a hole of 20 mm, wider than twice its band: the hole goes, the rim of the sheet stays open.
TEST(CloseVolume, SmallHolesOfASheetAreClosedAndItsRimIsNot) {
  const auto sheet = [](const Eigen::Vector3d& p) { return p.z() - 0.1 * p.x(); };
  const auto grid = test::scan_of(sheet, [](const Eigen::Vector3d& p) {
    return p.head<2>().norm() > 0.01 && p.head<2>().cwiseAbs().maxCoeff() < 0.08;
  });
  Closed closed = close(*grid, /*is_outside_free=*/false);
  const PatchCount count = keep_small_patches(0.04, closed.mesh, closed.invented);
  EXPECT_EQ(count.kept, 1u);
  const MeshCheck check = check_mesh(closed.mesh);
  EXPECT_TRUE(check.is_manifold());
  EXPECT_EQ(check.components, 1u);
  EXPECT_EQ(check.euler, 1);  // a disc
  EXPECT_EQ(moved(closed), 0u);
  // Cells that were seen in part count as invented: up to a voxel's diagonal round the hole.
  const double invented_m2 = area_m2(closed.mesh, closed.invented);
  EXPECT_GT(invented_m2, 3.14159 * 0.01 * 0.01);
  EXPECT_LT(invented_m2, 3.14159 * std::pow(0.01 + 1.42 * kVoxel, 2));
}

TEST(CloseVolume, AHoleThatIsTooLargeStaysOpen) {
  const auto grid = test::scan_of(test::ball(0.08), [](const Eigen::Vector3d& p) { return p.z() > -0.03; });
  Closed closed = close(*grid, /*is_outside_free=*/false);
  const PatchCount count = keep_small_patches(0.05, closed.mesh, closed.invented);
  EXPECT_EQ(count.kept, 0u);
  EXPECT_EQ(closed.mesh.triangles.size(), closed.open.triangles.size());
  EXPECT_EQ(check_mesh(closed.mesh).boundary_edges, check_mesh(closed.open).boundary_edges);
}

TEST(CloseVolume, ACutIsAPlane) {
  const auto grid = test::scan_of(test::block({0.06, 0.06, 0.06}), [](const Eigen::Vector3d&) { return true; });
  CloseRequest request = test::all_of(test::mesh_of(*grid));
  request.cut_m = [](const Eigen::Vector3d& p) { return -0.0313 - p.z(); };
  const auto volume = close_volume(test::view_of(*grid), request);
  ASSERT_TRUE(volume);
  const Mesh mesh = test::mesh_of(*volume->field);
  expect_closed(mesh, 2);
  EXPECT_NEAR(test::box_of(mesh).min().z(), -0.0313, 1e-6);
}

TEST(CloseVolume, RefusesABoxBeyondItsMemory) {
  const auto grid = test::scan_of(test::ball(0.08), [](const Eigen::Vector3d&) { return true; });
  CloseRequest request = test::all_of(test::mesh_of(*grid));
  request.memory_bytes = 1000;
  const auto volume = close_volume(test::view_of(*grid), request);
  ASSERT_FALSE(volume);
  EXPECT_EQ(volume.error().code, ErrorCode::kBudget);
  EXPECT_NE(volume.error().text().find("finish.crop"), std::string::npos);
}

TEST(SmallestSurface, TakesNoMoreMemoryThanItMay) {
  VoxelBox box;
  box.dims = {40, 48, 56};
  std::vector<VoxelLabel> labels(box.voxels(), VoxelLabel::kUnknown);
  std::vector<float> distance_m(box.voxels());
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const Eigen::Vector3i at = box.place(i);
    distance_m[i] = static_cast<float>(at.z() - 28) * 0.01f;
    if (at.x() < 20 || (at.array() == 0).any()) labels[i] = at.z() < 28 ? VoxelLabel::kMatter : VoxelLabel::kFree;
  }
  const KnownDistances known{distance_m, 0.01f};
  const FilledField whole = fill_by_smallest_surface(box, labels, known, 4);
  EXPECT_EQ(whole.distance_vox.size(), box.voxels());
  EXPECT_GE(whole.bytes, kLeastFillBytesPerVoxel * box.voxels());
  EXPECT_EQ(fill_by_smallest_surface(box, labels, known, 4, whole.bytes).distance_vox, whole.distance_vox);
  const FilledField refused = fill_by_smallest_surface(box, labels, known, 4, whole.bytes - 1);
  EXPECT_TRUE(refused.distance_vox.empty());
  EXPECT_EQ(refused.bytes, whole.bytes);
}

TEST(VoxelSet, NumbersItsMembersInTheirOrder) {
  constexpr std::size_t kVoxels = 1000;
  const VoxelSet thirds = VoxelSet::where(kVoxels, [](std::size_t i) { return i % 3 == 1; });
  ASSERT_EQ(thirds.size(), kVoxels / 3);
  std::vector<std::size_t> member(thirds.size());
  thirds.for_each([&](std::size_t i, std::size_t n) { member[n] = i; });
  for (std::size_t n = 0; n < member.size(); ++n) {
    EXPECT_EQ(member[n], 3 * n + 1);
    EXPECT_TRUE(thirds.contains(member[n]));
    EXPECT_FALSE(thirds.contains(member[n] + 1));
    EXPECT_EQ(thirds.number(member[n]), n);
  }
}

TEST(Invented, IsPaintedAndTheRestKeepsItsColour) {
  const auto grid = test::scan_of(test::ball(0.05), [](const Eigen::Vector3d& p) { return p.z() > -0.02; });
  Closed closed = close(*grid);
  const Rgb8 magenta{255, 0, 255};
  paint_invented(closed.invented, magenta, closed.mesh);
  std::size_t painted = 0;
  for (std::size_t i = 0; i < closed.mesh.colours.size(); ++i) {
    const bool is_painted = closed.mesh.colours[i] == magenta;
    painted += is_painted ? 1 : 0;
    if (is_painted) {
      EXPECT_LT(closed.mesh.positions_m[i].z(), -0.02f + 2 * static_cast<float>(kVoxel));
    }
  }
  EXPECT_GT(painted, 50u);
  EXPECT_LT(painted, closed.mesh.colours.size() / 2);
}

}  // namespace
}  // namespace scanknit
