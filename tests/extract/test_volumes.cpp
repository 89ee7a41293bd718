// What counts as observed, which volumes are refused, and odd volumes.
#include <gtest/gtest.h>
#include <openvdb/tools/LevelSetSphere.h>

#include <cmath>
#include <functional>
#include <limits>

#include "extract/blocks/sign_bytes.h"
#include "tests/extract/volumes.h"

namespace scanknit {
namespace {

using test::Dense;

Dense half_space(int n) {
  return test::dense_from(n, [](double x, double, double) { return x - 3.5; });
}

ErrorCode error_of(const FieldView& view, const ExtractConfig& config = {}) {
  const Result<Surface> surface = extract_surface(view, config);
  return surface ? ErrorCode::kInternal : surface.error().code;
}

TEST(Volume, EmptyGridGivesAnEmptyMesh) {
  const auto grid = test::make_grid(Dense(0));
  const Result<Surface> surface = extract_surface(test::view_of(*grid), {});
  ASSERT_TRUE(surface);
  EXPECT_TRUE(surface->mesh.empty());
}

TEST(Volume, IsovalueBeyondEverySampleGivesAnEmptyMesh) {
  for (const double isovalue : {1e3, -1e3, 1e300, -1e300}) {
    ExtractConfig config;
    config.isovalue = isovalue;
    EXPECT_TRUE(test::extract(half_space(10), config).mesh.empty()) << isovalue;
  }
}

TEST(Volume, OpenVdbLevelSetIsExtractedByItsActiveVoxels) {
  openvdb::initialize();
  const auto grid = openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(0.5f, openvdb::Vec3f(0.1f, 0, 0), 0.05f);
  const MeshCheck check = check_mesh(extract_surface(test::view_of(*grid), {}).value().mesh);
  EXPECT_TRUE(check.is_closed());
  EXPECT_EQ(check.euler, 2);
}

TEST(Volume, InactiveVoxelsAreUnobserved) {
  const auto grid = test::make_grid(half_space(10));
  for (int y = 0; y < 10; ++y) {
    for (int z = 0; z < 10; ++z) grid->tree().setValueOff({4, y, z});
  }
  EXPECT_TRUE(extract_surface(test::view_of(*grid), {}).value().mesh.empty());
}

TEST(Volume, VoxelsWithoutWeightAreUnobserved) {
  const auto field = test::make_grid(half_space(10));
  Dense weights(10, 1);
  for (int z = 0; z < 10; ++z) weights.at(3, 5, z) = 0;
  const auto weight = test::make_grid(weights);
  FieldView view = test::view_of(*field);
  view.weight = weight.get();
  const MeshCheck check = check_mesh(extract_surface(view, {}).value().mesh);
  EXPECT_EQ(check.triangles, 2u * 9 * 7);  // two of nine columns of cells are gone
}

TEST(Volume, VoxelsBelowTheMinimumWeightAreUnobserved) {
  const auto field = test::make_grid(half_space(10));
  const auto weight = test::make_grid(Dense(10, 2));
  FieldView view = test::view_of(*field);
  view.weight = weight.get();
  ExtractConfig config;
  config.min_weight = 2;
  EXPECT_FALSE(extract_surface(view, config).value().mesh.empty());
  config.min_weight = 2.5;
  EXPECT_TRUE(extract_surface(view, config).value().mesh.empty());
}

TEST(Volume, WeightMayBeAConstant) {
  const auto field = test::make_grid(half_space(10));
  const auto weight = openvdb::FloatGrid::create(1);
  FieldView view = test::view_of(*field);
  view.weight = weight.get();
  EXPECT_EQ(check_mesh(extract_surface(view, {}).value().mesh).triangles, 2u * 9 * 9);
}

TEST(Volume, InfiniteSamplesAreUnobserved) {
  Dense volume = half_space(10);
  volume.at(4, 4, 4) = std::numeric_limits<float>::infinity();
  volume.at(3, 7, 7) = -std::numeric_limits<float>::infinity();
  const MeshCheck check = check_mesh(test::extract(volume).mesh);
  EXPECT_TRUE(check.is_well_formed);
  EXPECT_EQ(check.triangles, 2u * (81 - 8));
}

TEST(Volume, ActiveTilesCountAsTheirVoxels) {
  const auto grid = test::make_grid(Dense(0));
  grid->tree().addTile(1, {0, 0, 0}, -1, true);  // two constant leaves side by side
  grid->tree().addTile(1, {8, 0, 0}, 1, true);
  EXPECT_EQ(check_mesh(extract_surface(test::view_of(*grid), {}).value().mesh).triangles, 2u * 7 * 7);
}

TEST(Volume, ExtremeSamplesGiveFiniteVertices) {
  Dense volume = half_space(10);
  for (float& sample : volume.samples) sample = sample < 0 ? std::numeric_limits<float>::lowest() : 1e-45f;
  EXPECT_TRUE(check_mesh(test::extract(volume).mesh).is_well_formed);
}

/// The volume enclosed by a ball's surface in a grid whose index space is mapped by `change`.
double ball_volume(const std::function<void(openvdb::math::Transform&)>& change) {
  const auto grid = test::make_grid(test::dense_from(20, [](double x, double y, double z) {
    return std::hypot(x - 9.6, y - 9.3, z - 9.1) - 7;  // signed distance: matter is Low
  }));
  change(grid->transform());
  return signed_volume_m3(extract_surface(test::view_of(*grid), {}).value().mesh);
}
constexpr double kBallVolume = 4.0 / 3.0 * 3.14159265358979 * 343;
constexpr double kChordError = 0.02 * kBallVolume;  // chords of one voxel lie below an arc of radius 7: (1/7)^2

TEST(Volume, AnisotropicTransformIsFollowed) {
  const double volume = ball_volume([](auto& transform) { transform.preScale(openvdb::Vec3d(1, 2, 0.5)); });
  EXPECT_NEAR(volume, kBallVolume, kChordError);
}

TEST(Volume, RotatedTransformIsFollowed) {
  const double volume = ball_volume([](auto& transform) { transform.preRotate(0.5, openvdb::math::X_AXIS); });
  EXPECT_NEAR(volume, kBallVolume, kChordError);
}

TEST(Volume, MirroredTransformTurnsTheTrianglesRound) {
  const double volume = ball_volume([](auto& transform) { transform.preScale(openvdb::Vec3d(-1, 1, 1)); });
  EXPECT_NEAR(volume, kBallVolume, kChordError);
}

TEST(Volume, TransformBeyondTheRangeOfAFloatIsRefused) {
  const auto grid = test::make_grid(half_space(4));
  grid->setTransform(openvdb::math::Transform::createLinearTransform(1e35));
  EXPECT_EQ(error_of(test::view_of(*grid)), ErrorCode::kConfig);
}

TEST(Volume, FrustumTransformIsRefused) {
  const auto grid = test::make_grid(half_space(4));
  grid->setTransform(openvdb::math::Transform::createFrustumTransform(
      openvdb::BBoxd(openvdb::Vec3d(0), openvdb::Vec3d(8)), 0.5, 2, 1));
  EXPECT_EQ(error_of(test::view_of(*grid)), ErrorCode::kConfig);
}

TEST(Volume, VoxelsAtTheEndOfTheCoordinatesAreRefused) {
  for (const int end : {std::numeric_limits<int>::min(), std::numeric_limits<int>::max()}) {
    const auto grid = test::make_grid(half_space(4));
    grid->tree().setValue({0, end, 0}, 1);
    EXPECT_EQ(error_of(test::view_of(*grid)), ErrorCode::kConfig) << end;
  }
}

TEST(Volume, GridsOfDifferentTransformsAreRefused) {
  const auto field = test::make_grid(half_space(4));
  const auto weight = test::make_grid(Dense(4, 1), {{0, 0, 0}, 0.5, {}});
  FieldView view = test::view_of(*field);
  view.weight = weight.get();
  EXPECT_EQ(error_of(view), ErrorCode::kConfig);
}

TEST(Volume, IsovalueThatIsNoNumberIsRefused) {
  const auto grid = test::make_grid(half_space(4));
  ExtractConfig config;
  config.isovalue = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(error_of(test::view_of(*grid), config), ErrorCode::kConfig);
}

TEST(Volume, NegativeMinimumWeightIsRefused) {
  const auto grid = test::make_grid(half_space(4));
  ExtractConfig config;
  config.min_weight = -1;
  EXPECT_EQ(error_of(test::view_of(*grid), config), ErrorCode::kConfig);
}

TEST(FloatIsovalue, SeparatesTheSameFloatsAsTheDouble) {
  for (const double isovalue : {0.0, 0.1, -0.1, 1e-50, -1e-50, 3.0, 1e300, -1e300}) {
    const float limit = float_isovalue(isovalue);
    const float below = std::nextafter(limit, -std::numeric_limits<float>::infinity());
    if (std::isfinite(limit)) {
      EXPECT_GE(static_cast<double>(limit), isovalue);
    }
    if (std::isfinite(below)) {
      EXPECT_LT(static_cast<double>(below), isovalue);
    }
  }
}

}  // namespace
}  // namespace scanknit
