#include <gtest/gtest.h>

#include "export/measure/doubled_surface.h"

namespace scanknit {
namespace {

constexpr float kVoxel = 0.01f;
constexpr int kSide = 60;  // voxels

/// A square sheet at this height, in voxels, of 60 voxels a side, that faces up or down.
void add_sheet(float height, bool faces_up, int side, Mesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.positions_m.size());
  for (int y = 0; y <= side; ++y) {
    for (int x = 0; x <= side; ++x) {
      mesh.positions_m.push_back(kVoxel *
                                 Eigen::Vector3f(static_cast<float>(x) + 0.3f, static_cast<float>(y) + 0.3f, height));
      mesh.normals.push_back(Eigen::Vector3f(0, 0, faces_up ? 1 : -1));
    }
  }
  const auto at = [&](int x, int y) { return first + static_cast<std::uint32_t>(y * (side + 1) + x); };
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      mesh.triangles.emplace_back(at(x, y), at(x + 1, y), at(x + 1, y + 1));
      mesh.triangles.emplace_back(at(x, y), at(x + 1, y + 1), at(x, y + 1));
    }
  }
}

DoubledSurface doubled(float gap, bool faces_up, int side = kSide) {
  Mesh mesh;
  add_sheet(0.4f, true, kSide, mesh);
  add_sheet(0.4f + gap, faces_up, side, mesh);
  return find_doubled_surface(mesh, kVoxel);
}

TEST(DoubledSurface, IsTwoSheetsThatFaceTheSameWay) {
  for (const float gap : {2.0f, 3.3f, 5.0f}) {
    const DoubledSurface found = doubled(gap, true);
    EXPECT_NEAR(found.share, 1, 1e-6) << gap;
    EXPECT_NEAR(found.area_m2, 2 * 0.36, 1e-3) << gap;
  }
  EXPECT_NEAR(doubled(3, true, kSide / 2).area_m2, 2 * 0.09, 0.01);  // the second covers a quarter of the first
}

TEST(DoubledSurface, IsNotAThinPlateNorSheetsFarApart) {
  EXPECT_EQ(doubled(3, false).share, 0);
  EXPECT_EQ(doubled(8, true).share, 0);
  EXPECT_EQ(doubled(0.5f, true).share, 0);
}

TEST(DoubledSurface, OfNothingIsNothing) {
  EXPECT_EQ(find_doubled_surface(Mesh(), kVoxel).area_m2, 0);
}

}  // namespace
}  // namespace scanknit
