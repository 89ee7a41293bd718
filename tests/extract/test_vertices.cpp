// Where vertices lie, their normals and colours.
#include <gtest/gtest.h>

#include <cmath>

#include <Eigen/Geometry>

#include "tests/extract/volumes.h"

namespace scanknit {
namespace {

using test::Dense;

/// Positions of a unit grid below 32, rounded to floats.
constexpr float kRounding = 4e-6f;

Dense plane(int n, const Eigen::Vector3d& normal, double offset) {
  return test::dense_from(n,
                          [=](double x, double y, double z) { return normal.dot(Eigen::Vector3d(x, y, z)) - offset; });
}

TEST(Vertices, LieOnAPlaneExactly) {
  const Eigen::Vector3d normal = Eigen::Vector3d(1, 2, -3).normalized();
  const Mesh mesh = test::extract(plane(20, normal, 0.7)).mesh;
  ASSERT_FALSE(mesh.empty());
  // Where the plane passes a grid point, a vertex keeps 1/1024 of an edge from it.
  constexpr double kMargin = 1.0 / 1024;
  for (const Eigen::Vector3f& p : mesh.positions_m)
    ASSERT_NEAR(normal.dot(p.cast<double>()), 0.7, kMargin + static_cast<double>(kRounding));
}

TEST(Vertices, AreWhereTheLinearInterpolantMeetsTheIsovalue) {
  const Mesh mesh = test::extract(plane(12, Eigen::Vector3d::UnitX(), 4.375)).mesh;
  for (const Eigen::Vector3f& p : mesh.positions_m) ASSERT_EQ(p.x(), 4.375f);
}

TEST(Vertices, KeepAMarginFromGridPointsOnTheIsovalue) {
  const Mesh mesh = test::extract(plane(12, Eigen::Vector3d::UnitX(), 5)).mesh;
  ASSERT_FALSE(mesh.empty());
  for (const Eigen::Vector3f& p : mesh.positions_m) ASSERT_EQ(p.x(), 5.0f - 1.0f / 1024.0f);
}

TEST(Vertices, AreInTheMiddleOfEdgesWhenAsked) {
  ExtractConfig config;
  config.placement = VertexPlacement::kMidEdge;
  const Mesh mesh = test::extract(plane(12, Eigen::Vector3d::UnitX(), 4.375), config).mesh;
  for (const Eigen::Vector3f& p : mesh.positions_m) ASSERT_EQ(p.x(), 4.5f);
}

TEST(Vertices, NormalsOfALinearFieldAreItsGradient) {
  const Eigen::Vector3d normal = Eigen::Vector3d(1, 2, -3).normalized();
  const Mesh mesh = test::extract(plane(20, normal, 0.7)).mesh;  // one-sided differences at the border as well
  constexpr float kGradientRounding = 1e-5f;                     // float samples up to 40
  for (const Eigen::Vector3f& n : mesh.normals) ASSERT_LT((n - normal.cast<float>()).norm(), kGradientRounding);
}

TEST(Vertices, NormalsPointOutOfMatterThatIsHigh) {
  ExtractConfig config;
  config.inside = InsideSide::kHigh;
  const Mesh mesh = test::extract(plane(12, Eigen::Vector3d::UnitX(), 4.375), config).mesh;
  for (const Eigen::Vector3f& n : mesh.normals) ASSERT_EQ(n, Eigen::Vector3f(-1, 0, 0));
}

TEST(Vertices, HaveNoNormalsWhenNotAsked) {
  ExtractConfig config;
  config.normals = false;
  EXPECT_TRUE(test::extract(plane(12, Eigen::Vector3d::UnitX(), 4.375), config).mesh.normals.empty());
}

TEST(Vertices, NormalsComeFromTrianglesWhereTheGradientVanishes) {
  // High layers at x = 4 and 6, Low between and around: along x the central differences at the layers' ends cancel.
  const Dense volume =
      test::dense_from(11, [](double x, double, double) { return static_cast<int>(x) % 2 == 0 ? 1.0 : -1.0; });
  const Mesh mesh = test::extract(volume).mesh;
  ASSERT_FALSE(mesh.empty());
  for (const Eigen::Vector3f& n : mesh.normals) {
    ASSERT_EQ(std::abs(n.x()), 1.0f);
    ASSERT_EQ(n.tail<2>(), Eigen::Vector2f::Zero());
  }
  for (const Triangle& t : mesh.triangles) {
    const Eigen::Vector3f facet =
        (mesh.positions_m[t[1]] - mesh.positions_m[t[0]]).cross(mesh.positions_m[t[2]] - mesh.positions_m[t[0]]);
    const bool is_inner = mesh.positions_m[t[0]].x() > 1 && mesh.positions_m[t[0]].x() < 9;
    if (is_inner) {
      ASSERT_GT(facet.dot(mesh.normals[t[0]]), 0);
    }
  }
}

struct ColouredPlane {
  openvdb::FloatGrid::Ptr field = test::make_grid(plane(8, Eigen::Vector3d::UnitX(), 3.25));
  openvdb::Vec3SGrid::Ptr colour = openvdb::Vec3SGrid::create(openvdb::Vec3s(-1));

  /// Colours every voxel of the layer at x.
  void paint(int x, const openvdb::Vec3s& rgb) {
    for (int y = 0; y < 8; ++y) {
      for (int z = 0; z < 8; ++z) colour->tree().setValueOn({x, y, z}, rgb);
    }
  }
  [[nodiscard]] Mesh mesh() const {
    FieldView view = test::view_of(*field);
    view.colour = colour.get();
    return extract_surface(view, {}).value().mesh;
  }
  void expect_all(const Rgb8& expected) const {
    const Mesh result = mesh();
    ASSERT_EQ(result.colours.size(), result.positions_m.size());
    ASSERT_FALSE(result.colours.empty());
    for (const Rgb8& rgb : result.colours)
      ASSERT_TRUE(rgb == expected) << int{rgb.r} << " " << int{rgb.g} << " " << int{rgb.b};
  }
};

TEST(Colours, AreInterpolatedAlongTheEdge) {
  ColouredPlane scene;
  scene.paint(3, {0, 0.4f, 1});
  scene.paint(4, {1, 0.4f, 0});
  scene.expect_all({64, 102, 191});  // a quarter of the way: 63.75, 102, 191.25
}

TEST(Colours, OfOneEndAloneAreTaken) {
  ColouredPlane scene;
  scene.paint(4, {1, 0.4f, 0});
  scene.expect_all({255, 102, 0});
}

TEST(Colours, ComeFromTheNearestColouredVoxelWhenBothEndsHaveNone) {
  ColouredPlane scene;
  scene.paint(2, {0, 1, 0});
  scene.expect_all({0, 255, 0});
}

TEST(Colours, AreMidGreyWhereNothingWasSeen) {
  ColouredPlane().expect_all({128, 128, 128});
}

TEST(Colours, OutsideZeroToOneAreClamped) {
  ColouredPlane scene;
  scene.paint(3, {7, 0, 0});
  scene.paint(4, {7, 0, 0});
  scene.expect_all({255, 0, 0});
}

TEST(Colours, NotANumberIsNoColour) {
  ColouredPlane scene;
  scene.paint(3, {test::kNaN, 0, 0});
  scene.paint(4, {0, 0, 1});
  scene.expect_all({0, 0, 255});
}

TEST(Colours, AreAbsentWithoutAColourGrid) {
  EXPECT_TRUE(test::extract(plane(8, Eigen::Vector3d::UnitX(), 3.25)).mesh.colours.empty());
}

}  // namespace
}  // namespace scanknit
