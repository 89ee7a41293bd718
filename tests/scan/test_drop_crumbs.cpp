// Pieces that few frames confirm, beside a wall that all of them see.
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "scan/mesh/drop_crumbs.h"

namespace scanknit {
namespace {

constexpr double kWall_m = 1.5;
constexpr CameraIntrinsics kCamera = {160, 120, 130, 130, 79.5, 59.5};
const FitBand kBand = {0.016, 3, NoiseModel{}};

/// Adds a square of side `side_m`, seen from the origin along z.
void add_square(double z, double side_m, Mesh& mesh) {
  constexpr int kSteps = 10;
  const auto first = static_cast<std::uint32_t>(mesh.positions_m.size());
  for (int y = 0; y <= kSteps; ++y) {
    for (int x = 0; x <= kSteps; ++x) {
      const Eigen::Vector3d p(side_m * (x - kSteps / 2) / kSteps, side_m * (y - kSteps / 2) / kSteps, z);
      mesh.positions_m.push_back(p.cast<float>());
      mesh.normals.emplace_back(0, 0, -1);
    }
  }
  for (std::uint32_t y = 0; y < kSteps; ++y) {
    for (std::uint32_t x = 0; x < kSteps; ++x) {
      const std::uint32_t corner = first + y * (kSteps + 1) + x;
      mesh.triangles.push_back({corner, corner + kSteps + 1, corner + 1});
      mesh.triangles.push_back({corner + 1, corner + kSteps + 1, corner + kSteps + 2});
    }
  }
}

/// Frames of the wall from the origin, with noise; the first `with_box` of them show a box before it, 40 pixels wide.
class Frames {
 public:
  Frames(std::size_t count, std::size_t with_box, double box_m) {
    std::mt19937 random(1);
    std::normal_distribution<double> noise(0, 1);
    for (std::size_t i = 0; i < count; ++i) {
      DepthImage depth_m(kCamera.width, kCamera.height);
      for (int y = 0; y < kCamera.height; ++y) {
        for (int x = 0; x < kCamera.width; ++x) {
          const bool is_box = i < with_box && std::abs(x - 80) < 20 && std::abs(y - 60) < 20;
          const double z = is_box ? box_m : kWall_m;
          depth_m.at(x, y) = static_cast<float>(z + kBand.noise.sigma_m(z) * noise(random));
        }
      }
      pictures_.push_back(std::move(depth_m));
    }
    for (const DepthImage& picture : pictures_) posed_.push_back({&picture, kCamera, Pose::Identity()});
  }
  [[nodiscard]] std::span<const PosedDepth> posed() const { return posed_; }

 private:
  std::vector<DepthImage> pictures_;
  std::vector<PosedDepth> posed_;
};

Mesh wall_and_square_at(double z) {
  Mesh mesh;
  add_square(kWall_m, 1.4, mesh);
  add_square(z, 0.1, mesh);
  return mesh;
}

TEST(Crumbs, APieceThatSeveralFramesSawStaysHoweverSmall) {
  const Frames frames(40, 8, 1);
  Mesh mesh = wall_and_square_at(1);
  EXPECT_EQ(drop_crumbs(frames.posed(), kBand, mesh).pieces, 0u);
}

TEST(Crumbs, APieceThatOneFrameSawIsLeftOutAndCounted) {
  const Frames frames(40, 1, 1);
  Mesh mesh = wall_and_square_at(1);
  const PiecesRemoved removed = drop_crumbs(frames.posed(), kBand, mesh);
  EXPECT_EQ(removed.pieces, 1u);
  EXPECT_EQ(removed.triangles, 200u);
  EXPECT_NEAR(removed.area_m2, 0.01, 1e-6);
  EXPECT_EQ(check_mesh(mesh).components, 1u);
}

TEST(Crumbs, NoiseThatFloatsBesideASurfaceIsNotConfirmedByIt) {
  const Frames frames(40, 0, 0);
  Mesh mesh = wall_and_square_at(kWall_m - 2 * kBand.noise.sigma_m(kWall_m));
  EXPECT_EQ(drop_crumbs(frames.posed(), kBand, mesh).pieces, 1u);
}

TEST(Crumbs, AScanOfFewFramesKeepsWhatOneOfThemSaw) {
  const Frames frames(4, 1, 1);
  Mesh mesh = wall_and_square_at(1);
  EXPECT_EQ(drop_crumbs(frames.posed(), kBand, mesh).pieces, 0u);
}

TEST(Crumbs, AreNotLookedForWithoutFrames) {
  Mesh mesh = wall_and_square_at(1);
  EXPECT_EQ(drop_crumbs({}, kBand, mesh).pieces, 0u);
}

TEST(Crumbs, LargePiecesStayWhoeverSawThem) {
  const Frames frames(40, 1, 1);
  Mesh mesh;
  add_square(kWall_m, 1.4, mesh);
  add_square(1, 0.5, mesh);  // an eighth of the wall
  EXPECT_EQ(drop_crumbs(frames.posed(), kBand, mesh).pieces, 0u);
}

}  // namespace
}  // namespace scanknit
