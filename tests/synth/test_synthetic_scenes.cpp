#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/counter_random.h"
#include "synth/render.h"
#include "synth/scene/analytic_scene.h"
#include "synth/scene/camera_paths.h"
#include "synth/scene/scene.h"
#include "synth/scene/scene_names.h"
#include "synth/scene/surface_samples.h"
#include "tests/synth/test_synthetic_meshes.h"

namespace scanknit {
namespace {

using Eigen::Vector3d;

constexpr double kArithmetic_m = 1e-12;  // a few roundings of double at the scale of a metre
constexpr double kPromised_m = 1e-6;     // what scene.h promises of nearest()

Vector3d random_point(const Eigen::AlignedBox3d& box, std::uint64_t number) {
  CounterRandom random(7, 0, number);
  Vector3d p;
  for (int axis = 0; axis < 3; ++axis) p[axis] = box.min()[axis] + random.uniform() * box.sizes()[axis];
  return p;
}

class EveryScene : public ::testing::TestWithParam<std::string_view> {
 protected:
  std::unique_ptr<SyntheticScene> scene_ = *make_scene(GetParam());
};
INSTANTIATE_TEST_SUITE_P(Synthetic, EveryScene, ::testing::ValuesIn(kSceneNames),
                         [](const auto& scene) { return std::string(scene.param); });

TEST_P(EveryScene, IsTheOneOfThatName) {
  EXPECT_EQ(scene_->name(), GetParam());
}

TEST_P(EveryScene, HasRigidPosesTo1e12) {
  for (const Pose& pose : camera_path(*scene_, 50)) {
    const Eigen::Matrix3d r = pose.linear();
    EXPECT_LT((r.transpose() * r - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), kArithmetic_m);
    EXPECT_NEAR(r.determinant(), 1, kArithmetic_m);
  }
}

TEST_P(EveryScene, KeepsTheCameraUpright) {
  if (GetParam() == "calibration_board") GTEST_SKIP() << "its camera is tilted to all sides";
  for (const Pose& pose : camera_path(*scene_, 50)) {
    EXPECT_NEAR(pose.linear().col(0).y(), 0, kArithmetic_m);  // its x axis is level
    EXPECT_GT(pose.linear().col(1).y(), 0);                   // its y axis points down
  }
}

TEST_P(EveryScene, KeepsTheCameraClearOfEverything) {
  constexpr double kClearance_m = 0.25;
  for (const Pose& pose : camera_path(*scene_, 100)) EXPECT_GT(scene_->distance(pose.translation()), kClearance_m);
}

TEST_P(EveryScene, NeverOverstatesADistanceInFreeSpace) {
  // Lipschitz: two values differ by at most the distance between the points, or one of them is wrong.
  for (std::uint64_t i = 0; i < 2000; ++i) {
    const Vector3d p = random_point(scene_->bounds(), 2 * i);
    const Vector3d q = p + 0.1 * (random_point(scene_->bounds(), 2 * i + 1) - p);
    EXPECT_LE(std::abs(scene_->distance(p) - scene_->distance(q)), (p - q).norm() + kArithmetic_m);
  }
}

TEST_P(EveryScene, FindsFeetThatLieOnTheSurface) {
  for (std::uint64_t i = 0; i < 2000; ++i) {
    const SurfacePoint foot = scene_->nearest(random_point(scene_->bounds(), i));
    EXPECT_NEAR(foot.normal.norm(), 1, kArithmetic_m);
    if (scene_->distance(random_point(scene_->bounds(), i)) > 0) {
      EXPECT_NEAR(scene_->distance(foot.position), 0, kPromised_m);
    }
  }
}

TEST_P(EveryScene, MeetsRaysExactlyOnTheSurface) {
  constexpr double kHit_m = 1e-7;
  const auto poses = camera_path(*scene_, 6);
  const CameraIntrinsics camera{32, 24, 26, 26, 15.5, 11.5};
  for (const Pose& pose : poses) {
    for (int y = 0; y < camera.height; ++y) {
      for (int x = 0; x < camera.width; ++x) {
        const Ray ray{pose.translation(), (pose.linear() * camera.unproject(x, y, 1)).normalized()};
        const auto t = scene_->intersect(ray, kRenderRange_m);
        if (!t) continue;
        EXPECT_NEAR(scene_->distance(ray.at(*t)), 0, kHit_m);
        for (const double part : {0.25, 0.5, 0.9}) EXPECT_GT(scene_->distance(ray.at(part * *t)), 0);
      }
    }
  }
}

TEST_P(EveryScene, HasColoursThatVary) {
  const RenderedView view = render(*scene_, CameraIntrinsics{64, 48, 52, 52, 31.5, 23.5}, camera_path(*scene_, 1)[0]);
  double sum = 0;
  double squares = 0;
  double count = 0;
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) {
      if (view.depth_m.at(x, y) == 0) continue;
      const double g = view.colour.at(x, y).g;
      sum += g;
      squares += g * g;
      ++count;
    }
  }
  ASSERT_GT(count, 100);
  constexpr double kTexturedDeviation = 15;  // of 255: far above a flat surface's
  EXPECT_GT(std::sqrt(squares / count - sum / count * sum / count), kTexturedDeviation);
}

TEST(SyntheticScene, SaysWhichScenesThereAre) {
  const auto scene = make_scene("dessk");
  ASSERT_FALSE(scene);
  EXPECT_EQ(scene.error().code, ErrorCode::kUsage);
  EXPECT_NE(scene.error().message.find("sphere, turntable, tower, desk, plates, room, gallery, twins"),
            std::string::npos);
}

TEST(SyntheticScene, LooksAtTheObjectOnTheTurntable) {
  for (const Pose& pose : camera_path(**make_scene("turntable"), 20)) {
    const Vector3d centre_camera = pose.inverse() * Vector3d::Zero();
    EXPECT_NEAR(centre_camera.x(), 0, kArithmetic_m);
    EXPECT_NEAR(centre_camera.y(), 0, kArithmetic_m);
    EXPECT_NEAR(centre_camera.z(), 0.6, kArithmetic_m);
  }
}

TEST(SyntheticScene, MovesThreeDegreesAndFiveCentimetresAFrameRoundTheDesk) {
  const auto poses = camera_path(**make_scene("desk"), 120);
  const Pose step = poses[10].inverse() * poses[11];
  EXPECT_NEAR(Eigen::AngleAxisd(step.linear()).angle() * 180 / std::numbers::pi, 3, 1e-9);
  EXPECT_NEAR(step.translation().norm(), 0.05, 0.0001);
}

TEST(SyntheticScene, SeesAllOfTheTurntableObject) {
  constexpr double kSeen = 0.995;  // a closed mesh needs all but the bottoms of a few creases
  const auto scene = *make_scene("turntable");
  const CameraIntrinsics camera{320, 240, 262.5, 262.5, 159.5, 119.5};
  std::vector<TruthPoint> points = sample_surface(*scene, 20'000, 1);
  for (const Pose& pose : camera_path(*scene, 60)) {
    count_views(render(*scene, camera, pose), ViewCamera(camera, pose), points);
  }
  std::size_t seen = 0;
  for (const TruthPoint& point : points) seen += point.views >= 2 ? 1 : 0;
  EXPECT_GT(static_cast<double>(seen) / static_cast<double>(points.size()), kSeen);
}

TEST(AnalyticScene, IsExactInsideAUnionNearASeam) {
  // Two spheres that overlap: their seam is a circle in the plane x = 0, of radius 0.8. From inside on that plane the
  // circle is nearest; the minimum of the two distances alone would say 0.0794.
  std::vector<Solid> solids;
  for (const double x : {-0.6, 0.6}) {
    Pose place = Pose::Identity();
    place.translation().x() = x;
    solids.emplace_back(Sphere{1.0}, place, Texture{});
  }
  const AnalyticScene scene("pair", turntable_path({}), 1, std::move(solids));
  EXPECT_NEAR(scene.surface_distance({0, 0.7, 0}), 0.1, kPromised_m);
  EXPECT_NEAR(scene.surface_distance({0, 0.798, 0}), 0.002, kPromised_m);
  EXPECT_NEAR(scene.surface_distance({1.59, 0, 0}), 0.01, kPromised_m);
}

TEST(SurfaceSamples, AreUniformByArea) {
  const auto scene = *make_scene("sphere");
  const auto points = sample_surface(*scene, 20'000, 1);
  ASSERT_EQ(points.size(), 20'000u);
  int above = 0;
  for (const TruthPoint& point : points) {
    EXPECT_NEAR(point.position_m.norm(), 0.1f, 1e-6f);
    above += point.position_m.y() > 0.05f ? 1 : 0;
  }
  // Archimedes: the cap above half the radius is a quarter of the sphere. Four deviations of the binomial.
  EXPECT_NEAR(above / 20'000.0, 0.25, 4 * std::sqrt(0.25 * 0.75 / 20'000));
}

TEST(MeshScene, AgreesWithTheSphereItApproximates) {
  constexpr int kLevels = 5;
  constexpr double kRadius_m = 0.1;
  const auto mesh_scene = make_mesh_scene(test::icosphere(1.0, kLevels), 2 * kRadius_m);
  ASSERT_TRUE(mesh_scene) << mesh_scene.error().text();
  const double tolerance =
      test::chord_error_m(1.0, kLevels) * kRadius_m + 1e-4;  // vertices need not reach the box's sides
  for (std::uint64_t i = 0; i < 500; ++i) {
    const Vector3d p = random_point((*mesh_scene)->bounds(), i);
    EXPECT_NEAR((*mesh_scene)->distance(p), p.norm() - kRadius_m, tolerance);
  }
}

TEST(MeshScene, TurnsAnInsideOutMeshRound) {
  Mesh mesh = test::icosphere(0.1, 2);
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  const auto scene = make_mesh_scene(mesh, 0.2);
  ASSERT_TRUE(scene);
  EXPECT_LT((*scene)->distance(Vector3d::Zero()), 0);
}

TEST(MeshScene, RefusesAnOpenMesh) {
  Mesh mesh = test::icosphere(0.1, 1);
  mesh.triangles.pop_back();
  const auto scene = make_mesh_scene(mesh, 0.2);
  ASSERT_FALSE(scene);
  EXPECT_EQ(scene.error().code, ErrorCode::kMesh);
  EXPECT_NE(scene.error().message.find("not closed"), std::string::npos);
}

TEST(MeshScene, RefusesAnEmptyMeshAndAnAbsurdSize) {
  EXPECT_EQ(make_mesh_scene(Mesh{}, 0.2).error().code, ErrorCode::kMesh);
  EXPECT_EQ(make_mesh_scene(test::icosphere(1, 0), 0).error().code, ErrorCode::kUsage);
  EXPECT_EQ(make_mesh_scene(test::icosphere(1, 0), std::nan("")).error().code, ErrorCode::kUsage);
}

TEST(MeshScene, RefusesBrokenIndicesAndNumbers) {
  Mesh bad_index = test::icosphere(0.1, 0);
  bad_index.triangles[0][0] = 99;
  EXPECT_EQ(make_mesh_scene(bad_index, 0.2).error().code, ErrorCode::kMesh);
  Mesh bad_number = test::icosphere(0.1, 0);
  bad_number.positions_m[0].x() = std::nanf("");
  EXPECT_EQ(make_mesh_scene(bad_number, 0.2).error().code, ErrorCode::kMesh);
}

TEST(MeshScene, InterpolatesVertexColours) {
  Mesh mesh = test::icosphere(0.1, 0);
  mesh.colours.assign(mesh.positions_m.size(), Rgb8{255, 0, 102});
  const auto scene = *make_mesh_scene(mesh, 0.2);
  const Vector3d colour = scene->colour(scene->nearest({0.3, 0.2, 0.1}));
  EXPECT_NEAR((colour - Vector3d(1, 0, 0.4)).norm(), 0, 1e-9);
}

}  // namespace
}  // namespace scanknit
