// The table under an object is found, and a wall is none.
#include <gtest/gtest.h>

#include <random>

#include "finish/mesh_steps.h"
#include "tests/core/sample_meshes.h"

namespace scanknit {
namespace {

/// A square of `side_m` round `middle`, spanned by u and v, facing u x v, with noise along that.
void add_square(const Eigen::Vector3d& middle, const Eigen::Vector3d& u, const Eigen::Vector3d& v, double side_m,
                double noise_m, Mesh& mesh) {
  constexpr int kCells = 60;
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, noise_m);
  const auto first = static_cast<std::uint32_t>(mesh.positions_m.size());
  for (int i = 0; i <= kCells; ++i) {
    for (int j = 0; j <= kCells; ++j) {
      const Eigen::Vector3d p =
          middle +
          side_m * ((static_cast<double>(i) / kCells - 0.5) * u + (static_cast<double>(j) / kCells - 0.5) * v) +
          noise(random) * u.cross(v);
      mesh.positions_m.push_back(p.cast<float>());
    }
  }
  const auto at = [&](int i, int j) { return first + static_cast<std::uint32_t>(i * (kCells + 1) + j); };
  for (int i = 0; i < kCells; ++i) {
    for (int j = 0; j < kCells; ++j) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
}

/// A table whose normal is 20 degrees off the world's up, a ball on it, a larger wall behind.
Mesh desk(const Eigen::Vector3d& up) {
  Mesh mesh;
  const Eigen::Vector3d u = up.unitOrthogonal();
  add_square({0.1, 0.2, 0.3}, u, up.cross(u), 0.6, 0.0005, mesh);
  add_square({0.1, 0.9, 0.6}, Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitX(), 1.2, 0.0005, mesh);
  const Mesh ball = test::sphere();
  const auto first = static_cast<std::uint32_t>(mesh.positions_m.size());
  for (const auto& p : ball.positions_m)
    mesh.positions_m.push_back(0.1f * p + (Eigen::Vector3d(0.1, 0.2, 0.3) + 0.1 * up).cast<float>());
  for (const Triangle& t : ball.triangles) mesh.triangles.emplace_back(first + t[0], first + t[1], first + t[2]);
  return mesh;
}

std::optional<GroundPlane> ground_of(const Mesh& mesh, const GroundSearch& search) {
  const auto found = find_ground(mesh, search);
  if (found) return *found;
  ADD_FAILURE() << found.error().text();
  return std::nullopt;
}

const Eigen::Vector3d kUp = Eigen::Vector3d(0.3, -0.15, 0.94).normalized();

TEST(GroundPlane, IsTheTableNotTheWall) {
  const auto ground = ground_of(desk(kUp), {.tolerance_m = 0.004});
  ASSERT_TRUE(ground);
  EXPECT_LT(std::acos(std::min(1.0, ground->up.dot(kUp))), 0.002);  // a tenth of a degree
  EXPECT_LT(std::abs(ground->height_m({0.1, 0.2, 0.3})), 0.0003);
  EXPECT_NEAR(ground->area_m2, 0.36, 0.02);
  EXPECT_NEAR(ground->rms_m, 0.0005 / std::sqrt(3.0), 0.00005);  // of triangles, means of three vertices
}

TEST(GroundPlane, IsTheSameEveryTime) {
  const Mesh mesh = desk(kUp);
  const auto once = ground_of(mesh, {.tolerance_m = 0.004});
  const auto again = ground_of(mesh, {.tolerance_m = 0.004});
  ASSERT_TRUE(once && again);
  EXPECT_TRUE(once->up == again->up && once->point == again->point);
}

TEST(GroundPlane, ThereIsNoneUnderABallOrInNothing) {
  EXPECT_FALSE(ground_of(test::sphere(), {.tolerance_m = 0.004}));
  EXPECT_FALSE(ground_of(Mesh(), {}));
}

// A ball on a plinth that is smaller than it: cutting at the plinth's top would cut the thing.
TEST(GroundPlane, ThePlinthOfAThingIsNone) {
  const auto scene = [](double side_m) {
    Mesh mesh;
    const Mesh ball = test::sphere();
    for (const auto& p : ball.positions_m) mesh.positions_m.push_back(0.1f * p + Eigen::Vector3f(0, 0, 0.1f));
    mesh.triangles = ball.triangles;
    add_square({0, 0, 0}, Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), side_m, 0, mesh);
    return mesh;
  };
  EXPECT_FALSE(ground_of(scene(0.12), {.tolerance_m = 0.004}));
  EXPECT_TRUE(ground_of(scene(0.4), {.tolerance_m = 0.004}));
}

TEST(GroundPlane, OfACeilingIsNone) {
  Mesh mesh;
  add_square({0, 0, 2}, Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitX(), 1, 0, mesh);  // faces down
  EXPECT_FALSE(ground_of(mesh, {}));
}

}  // namespace
}  // namespace scanknit
