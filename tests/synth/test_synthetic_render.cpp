#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "synth/render.h"
#include "synth/scene/analytic_scene.h"
#include "synth/scene/camera_paths.h"
#include "synth/synthetic_source.h"
#include "tests/support/places.h"
#include "tests/synth/test_synthetic_meshes.h"

namespace scanknit {
namespace {

using Eigen::Vector3d;

const CameraIntrinsics kCamera{160, 120, 131.25, 131.25, 79.5, 59.5};
constexpr double kFloat_m = 1e-6;  // exact depth, rounded to float below 4 m

/// Depth of a sphere at the world's origin by the quadratic formula; 0 where the ray misses.
double sphere_depth(double radius_m, const Pose& pose, const Vector3d& through) {
  const Vector3d d = through.normalized();
  const Vector3d centre = pose.inverse() * Vector3d::Zero();
  const double b = d.dot(centre);
  const double discriminant = b * b - centre.squaredNorm() + radius_m * radius_m;
  return discriminant < 0 ? 0 : (b - std::sqrt(discriminant)) * d.z();
}

TEST(Render, GivesTheDepthOfASphereInClosedForm) {
  const auto scene = *make_scene("sphere");
  const Pose pose = camera_path(*scene, 7)[2];
  const RenderedView view = render(*scene, kCamera, pose);
  int hits = 0;
  for (int y = 0; y < kCamera.height; ++y) {
    for (int x = 0; x < kCamera.width; ++x) {
      const double expected = sphere_depth(0.1, pose, kCamera.unproject(x, y, 1));
      EXPECT_NEAR(view.depth_m.at(x, y), expected, kFloat_m) << x << "," << y;
      hits += expected > 0 ? 1 : 0;
    }
  }
  EXPECT_GT(hits, 1000);
}

TEST(Render, GivesTheDepthOfAPlaneInClosedForm) {
  std::vector<Solid> solids;
  solids.push_back(Solid::room({1, 1.5, 2}, Pose::Identity(), Texture{}));
  const AnalyticScene scene("box room", turntable_path({}), 1, std::move(solids));
  const RenderedView view = render(scene, kCamera, Pose::Identity());  // looks along z at the wall z = 2
  EXPECT_NEAR(view.depth_m.at(80, 60), 2.0, kFloat_m);
  const double left_wall = -1 / kCamera.unproject(0, 60, 1).x();  // x = -1 is met at this depth
  EXPECT_NEAR(view.depth_m.at(0, 60), left_wall, kFloat_m);
}

TEST(Render, PutsPixelCentresAtIntegers) {
  const auto scene = *make_scene("desk");
  const Pose pose = camera_path(*scene, 5)[1];
  const RenderedView view = render(*scene, kCamera, pose);
  for (int y = 0; y < kCamera.height; y += 7) {
    for (int x = 0; x < kCamera.width; x += 7) {
      const Vector3d p_camera = kCamera.unproject(x, y, static_cast<double>(view.depth_m.at(x, y)));
      EXPECT_NEAR(scene->surface_distance(pose * p_camera), 0, kFloat_m);
    }
  }
}

TEST(Render, GivesTheCosineOfTheIncidence) {
  const auto scene = *make_scene("sphere");
  const Pose pose = camera_path(*scene, 1)[0];
  const CameraIntrinsics odd{161, 121, 131.25, 131.25, 80, 60};  // a pixel looks along the axis
  EXPECT_NEAR(render(*scene, odd, pose).cos_incidence.at(80, 60), 1.0, 1e-6);
}

TEST(Render, GivesTheSameBitsForAnyNumberOfThreads) {
  const auto scene = *make_scene("desk");
  const Pose pose = camera_path(*scene, 5)[0];
  const auto with_threads = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return render(*scene, kCamera, pose);
  };
  const RenderedView one = with_threads(1);
  const RenderedView eight = with_threads(8);
  EXPECT_EQ(one.depth_m, eight.depth_m);
  EXPECT_EQ(one.colour, eight.colour);
  EXPECT_EQ(one.cos_incidence, eight.cos_incidence);
}

TEST(Render, SeesAMeshOfASphereAsTheSphere) {
  constexpr int kLevels = 5;
  const auto mesh_scene = *make_mesh_scene_as_is(test::icosphere(0.1, kLevels));
  const Pose pose = camera_path(**make_scene("sphere"), 3)[1];
  const RenderedView view = render(*mesh_scene, kCamera, pose);
  // Away from the rim the depth error is the chord error over the cosine of the incidence.
  for (int y = 0; y < kCamera.height; ++y) {
    for (int x = 0; x < kCamera.width; ++x) {
      if (view.cos_incidence.at(x, y) < 0.5f) continue;
      const double expected = sphere_depth(0.1, pose, kCamera.unproject(x, y, 1));
      EXPECT_NEAR(view.depth_m.at(x, y), expected, 2 * test::chord_error_m(0.1, kLevels) + kFloat_m);
    }
  }
}

/// Positions and faces of an OBJ of triangles and quadrangles.
Mesh parse_obj(std::istream& file) {
  Mesh mesh;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "v") {
      Eigen::Vector3f p;
      words >> p.x() >> p.y() >> p.z();
      mesh.positions_m.push_back(p);
    } else if (word == "f") {
      std::vector<std::uint32_t> corners;
      while (words >> word) corners.push_back(static_cast<std::uint32_t>(std::stoul(word)) - 1);
      for (std::size_t i = 2; i < corners.size(); ++i) {
        mesh.triangles.push_back({corners[0], corners[i - 1], corners[i]});
      }
    }
  }
  return mesh;
}

TEST(Render, SeesSpotStandingUpright) {
  const std::filesystem::path folder = test::data_folder();
  std::ifstream file(folder / "meshes/spot.obj");
  if (!file) GTEST_SKIP() << "SKIPPED: " << (folder / "meshes/spot.obj") << " is not there";
  const auto scene = make_mesh_scene(parse_obj(file), 0.2);
  ASSERT_TRUE(scene) << scene.error().text();
  EXPECT_NEAR((*scene)->bounds().sizes().maxCoeff(), 0.2, 1e-6);
  for (const Pose& pose : camera_path(**scene, 4)) {
    const RenderedView view = render(**scene, kCamera, pose);
    int hits = 0;
    for (int y = 0; y < kCamera.height; ++y) {
      for (int x = 0; x < kCamera.width; ++x) {
        const float depth = view.depth_m.at(x, y);
        if (depth == 0) continue;
        ++hits;
        const Vector3d p_world = pose * kCamera.unproject(x, y, static_cast<double>(depth));
        EXPECT_NEAR((*scene)->surface_distance(p_world), 0, kFloat_m);
      }
    }
    EXPECT_GT(hits, 300);
  }
}

TEST(SyntheticSource, GivesFramesWithTheirTruePosesThenEnds) {
  SynthConfig config;
  config.frames = 2;
  config.intrinsics = kCamera;
  auto source = SyntheticSource::create(*make_scene("sphere"), config);
  ASSERT_TRUE(source);
  const auto poses = camera_path((*source)->scene(), 2);
  for (std::uint64_t i = 0; i < 2; ++i) {
    const FrameEvent event = (*source)->next({});
    const Frame* frame = std::get_if<Frame>(&event);
    ASSERT_NE(frame, nullptr);
    EXPECT_EQ(frame->sequence, i);
    EXPECT_TRUE(frame->T_world_camera->isApprox(poses[i]));
    EXPECT_EQ(frame->colour->image.width(), kCamera.width);
  }
  EXPECT_TRUE(std::holds_alternative<EndOfStream>((*source)->next({})));
}

TEST(SyntheticSource, EndsWhenAskedToStop) {
  auto source = *SyntheticSource::create(*make_scene("sphere"), {});
  std::stop_source stop;
  stop.request_stop();
  EXPECT_TRUE(std::holds_alternative<EndOfStream>(source->next(stop.get_token())));
}

}  // namespace
}  // namespace scanknit
