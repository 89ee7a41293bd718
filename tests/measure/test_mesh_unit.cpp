#include <gtest/gtest.h>

#include "measure/area_points.h"
#include "measure/mesh_unit.h"
#include "tests/measure/known_shapes.h"

namespace scanknit {
namespace {

TEST(MeshUnit, AFactorOfAUnitIsRecognised) {
  EXPECT_EQ(unit_that_fits(0.1, 100, MeshUnit::kMetre), MeshUnit::kMillimetre);
  EXPECT_EQ(unit_that_fits(0.1, 0.0001, MeshUnit::kMillimetre), MeshUnit::kMetre);
  EXPECT_EQ(unit_that_fits(0.1, 0.1 / 25.4, MeshUnit::kMillimetre), MeshUnit::kInch);
  EXPECT_EQ(unit_that_fits(0.1, 0.1 / 0.0254 * 1.1, MeshUnit::kMetre), MeshUnit::kInch);
  EXPECT_EQ(unit_that_fits(0.1, 10, MeshUnit::kMetre), MeshUnit::kCentimetre);
}

TEST(MeshUnit, OtherFactorsAreNone) {
  EXPECT_EQ(unit_that_fits(0.1, 0.1, MeshUnit::kMetre), std::nullopt);
  EXPECT_EQ(unit_that_fits(0.1, 0.3, MeshUnit::kMetre), std::nullopt);
  EXPECT_EQ(unit_that_fits(0.1, 0.7, MeshUnit::kMetre), std::nullopt);
  EXPECT_EQ(unit_that_fits(0.1, 0, MeshUnit::kMetre), std::nullopt);
  EXPECT_EQ(unit_that_fits(0, 0, MeshUnit::kMetre), std::nullopt);
}

TEST(MeshUnit, InchesBesideMillimetresAreTold) {
  EXPECT_TRUE(differ_as_inch_and_millimetre(0.1, 2.54));
  EXPECT_TRUE(differ_as_inch_and_millimetre(2.6, 0.1));
  EXPECT_FALSE(differ_as_inch_and_millimetre(0.1, 3.9));
  EXPECT_FALSE(differ_as_inch_and_millimetre(0.1, 0.1));
  EXPECT_FALSE(differ_as_inch_and_millimetre(0, 1));
}

TEST(MeshUnit, PositionsAreScaledToMetres) {
  Mesh mesh = test::box(20, 40, 40);
  to_metres(mesh, MeshUnit::kInch);
  EXPECT_NEAR(diagonal_m(mesh), 60 * 0.0254, 1e-6);
}

TEST(CheckMeasurable, RefusesWhatHasNoMeasures) {
  EXPECT_FALSE(check_measurable({}));
  Mesh flat = test::box(0, 0, 1);
  EXPECT_FALSE(check_measurable(flat));
  Mesh wild = test::box(1, 1, 1);
  wild.triangles[3] = {0, 1, 8};
  EXPECT_FALSE(check_measurable(wild));
  wild = test::box(1, 1, 1);
  wild.positions_m[2].x() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(check_measurable(wild));
  EXPECT_TRUE(check_measurable(test::box(1, 1, 1)));
}

}  // namespace
}  // namespace scanknit
