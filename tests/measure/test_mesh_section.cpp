#include <gtest/gtest.h>

#include "measure/section/mesh_section.h"
#include "measure/section/section_drawing.h"
#include "tests/measure/known_shapes.h"

namespace scanknit {
namespace {

TEST(MeshSection, OfAPlateWithAHoleHasItsOutlineAndTheHole) {
  const Mesh plate = test::plate_with_hole(0.06, 0.01, 0.01);
  const MeshSection section = cut_mesh(plate, section_plane(Eigen::Vector3d::UnitZ(), 0.002));
  ASSERT_EQ(section.outlines.size(), 2u);
  EXPECT_EQ(section.open_outlines, 0u);
  EXPECT_NEAR(section.outlines[0].length_m, 4 * 0.06, 1e-7);
  EXPECT_NEAR(section.outlines[0].area_m2, 0.06 * 0.06, 1e-8);
  const double circle = 2 * std::numbers::pi * 0.01, disc = std::numbers::pi * 0.01 * 0.01;
  EXPECT_NEAR(section.outlines[1].length_m, circle, 0.001 * circle);
  EXPECT_NEAR(section.outlines[1].area_m2, -disc, 0.001 * disc);
  EXPECT_NEAR(section.area_m2, 0.06 * 0.06 - disc, 1e-6);
  EXPECT_TRUE((section.max_m - section.min_m).isApprox(Eigen::Vector2d(0.06, 0.06), 1e-6));
}

TEST(MeshSection, OfATurnedBallIsACircleWherePythagorasSays) {
  const Eigen::Vector3d normal = Eigen::Vector3d(1, -2, 0.5).normalized();
  const MeshSection section = cut_mesh(test::ball(0.05), section_plane(normal, 0.03));
  ASSERT_EQ(section.outlines.size(), 1u);
  const double radius = 0.04;  // 3, 4, 5
  EXPECT_NEAR(section.length_m, 2 * std::numbers::pi * radius, 0.01 * 2 * std::numbers::pi * radius);
  EXPECT_NEAR(section.area_m2, std::numbers::pi * radius * radius, 0.01 * std::numbers::pi * radius * radius);
}

TEST(MeshSection, ThroughVerticesIsClosedToo) {
  // The plane holds whole rings of vertices of the sphere, and four of the box's corners.
  const MeshSection equator = cut_mesh(test::sphere(), section_plane(Eigen::Vector3d::UnitZ(), 0));
  ASSERT_EQ(equator.outlines.size(), 1u);
  EXPECT_EQ(equator.open_outlines, 0u);
  EXPECT_NEAR(equator.area_m2, std::numbers::pi, 0.01);
  const Eigen::Vector3d diagonal = Eigen::Vector3d(1, -1, 0).normalized();
  const MeshSection across = cut_mesh(test::cube(), section_plane(diagonal, 0));
  ASSERT_EQ(across.outlines.size(), 1u);
  EXPECT_EQ(across.open_outlines, 0u);
  EXPECT_NEAR(across.area_m2, 2 * std::sqrt(8.0), 1e-6);
}

TEST(MeshSection, OfAnOpenSheetIsALineWithoutArea) {
  const MeshSection section = cut_mesh(test::sheet(0.1, 10), section_plane(Eigen::Vector3d::UnitX(), 0.003));
  ASSERT_EQ(section.outlines.size(), 1u);
  EXPECT_EQ(section.open_outlines, 1u);
  EXPECT_NEAR(section.length_m, 0.1, 1e-7);
  EXPECT_EQ(section.area_m2, 0);
}

TEST(MeshSection, BesideTheMeshIsEmpty) {
  const MeshSection section = cut_mesh(test::cube(), section_plane(Eigen::Vector3d::UnitZ(), 5));
  EXPECT_TRUE(section.outlines.empty());
  EXPECT_EQ(section.length_m, 0);
  EXPECT_NE(section_svg(section).find("</svg>"), std::string::npos);
  EXPECT_NE(section_dxf(section).find("EOF"), std::string::npos);
}

TEST(SectionPlane, HasARightHandedFrame) {
  for (const Eigen::Vector3d& n : {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0, 0, -1), Eigen::Vector3d(0, 1, 0),
                                   Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0.6, 0, 0.8)}) {
    const SectionPlane plane = section_plane(n, 0);
    EXPECT_TRUE(plane.right.cross(plane.up).isApprox(n, 1e-12)) << n.transpose();
  }
}

TEST(SectionDrawing, DxfHasAPolylineForEachOutlineInMillimetres) {
  const std::string dxf =
      section_dxf(cut_mesh(test::plate_with_hole(0.0625, 0.01, 0.01), section_plane(Eigen::Vector3d::UnitZ(), 0)));
  std::size_t polylines = 0;
  for (std::size_t at = dxf.find("\nPOLYLINE\n"); at != std::string::npos; at = dxf.find("\nPOLYLINE\n", at + 1)) {
    ++polylines;
  }
  EXPECT_EQ(polylines, 2u);
  EXPECT_NE(dxf.find("10\n31.250000\n"), std::string::npos);
  EXPECT_NE(dxf.find("8\nHOLES\n"), std::string::npos);
  EXPECT_TRUE(dxf.ends_with("0\nENDSEC\n0\nEOF\n"));
}

TEST(SectionDrawing, SvgIsInTrueSize) {
  const std::string svg =
      section_svg(cut_mesh(test::box(0.02, 0.03, 0.05), section_plane(Eigen::Vector3d::UnitZ(), 0)));
  EXPECT_NE(svg.find("mm\" viewBox=\"0 0 "), std::string::npos);
  EXPECT_NE(svg.find("20 x 30 mm, outlines 100 mm, area 600 mm2"), std::string::npos) << svg;
}

}  // namespace
}  // namespace scanknit
