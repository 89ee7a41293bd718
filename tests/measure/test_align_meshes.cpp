#include <gtest/gtest.h>

#include "measure/area_points.h"
#include "measure/compare/compare_meshes.h"
#include "measure/compare/fit_meshes.h"
#include "measure/compare/point_pairs.h"
#include "measure/compare/shape_search.h"
#include "measure/turns.h"
#include "tests/measure/known_shapes.h"

namespace scanknit {
namespace {

/// How far the farthest vertex is from where it belongs.
double worst_place_m(const Mesh& mesh, const Pose& T_found, const Pose& T_true) {
  double worst = 0;
  for (const Eigen::Vector3f& p : mesh.positions_m) {
    worst = std::max(worst, (T_found * p.cast<double>() - T_true * p.cast<double>()).norm());
  }
  return worst;
}

constexpr double kFoundM = 2e-6;  // of a body of 10 cm

TEST(AlignMeshes, AShapeIsFoundWhereverItLies) {
  const Mesh reference = test::lump();
  for (const double turn : {1.9, 3.0}) {
    Pose T_moved_reference = test::some_pose();
    T_moved_reference.linear() = Eigen::AngleAxisd(turn, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
    const Mesh mesh = test::moved(reference, T_moved_reference);
    const ShapePlacement found = find_by_shape(mesh, reference);
    EXPECT_FALSE(found.is_ambiguous);
    const auto points = positions_of(spread_over_area(mesh, 5000));
    const Pose fitted = fit_points(points, SignedDistance(reference), found.T_reference_mesh);
    EXPECT_LT(worst_place_m(mesh, fitted, T_moved_reference.inverse()), kFoundM) << turn;
  }
}

TEST(AlignMeshes, ABoxIsAmbiguousButFitsAllTheSame) {
  const Mesh reference = test::box(0.04, 0.06, 0.08);
  const Mesh mesh = test::moved(reference, test::some_pose());
  const ShapePlacement found = find_by_shape(mesh, reference);
  EXPECT_TRUE(found.is_ambiguous);
  const ComparedMeshes compared = compare_meshes(test::moved(mesh, found.T_reference_mesh), reference);
  EXPECT_LT(compared.deviation.area.max_absolute_m, 1e-5);
}

TEST(AlignMeshes, ADentDoesNotPullTheBestFitAlong) {
  const Mesh reference = test::lump();
  Mesh dented = reference;
  for (Eigen::Vector3f& p : dented.positions_m) {
    const float away = (p - Eigen::Vector3f(0.06f, 0, 0)).norm();
    if (away < 0.02f) p -= 0.003f * (1 - away / 0.02f) * p.normalized();
  }
  Pose nudge = Pose::Identity();
  nudge.linear() = Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitY()).toRotationMatrix();
  nudge.translation() = Eigen::Vector3d(0.002, -0.001, 0.003);
  const Mesh mesh = test::moved(dented, nudge);
  const Pose fitted =
      fit_points(positions_of(spread_over_area(mesh, 10'000)), SignedDistance(reference), Pose::Identity());
  EXPECT_LT(worst_place_m(mesh, fitted, nudge.inverse()), 2e-5);  // 1 % of 3 mm is 3e-5
}

TEST(AlignMeshes, ABallMayTurnAndStays) {
  const Mesh reference = test::ball(0.05);
  Pose shift = Pose::Identity();
  shift.translation() = Eigen::Vector3d(0.004, 0.001, -0.002);
  const Mesh mesh = test::moved(reference, shift);
  const Pose fitted =
      fit_points(positions_of(spread_over_area(mesh, 5000)), SignedDistance(reference), Pose::Identity());
  EXPECT_LT((fitted.translation() + shift.translation()).norm(), 5e-5);  // facets, turned against each other
  EXPECT_LT(Eigen::AngleAxisd(fitted.linear()).angle(), 0.05);
}

TEST(AlignMeshes, SixtyTurnsAreSixty) {
  const auto turns = icosahedral_rotations();
  ASSERT_EQ(turns.size(), 60u);
  double nearest = 10;
  for (std::size_t i = 0; i < turns.size(); ++i) {
    EXPECT_NEAR(turns[i].norm(), 1, 1e-12);
    for (std::size_t j = 0; j < i; ++j) nearest = std::min(nearest, turns[i].angularDistance(turns[j]));
  }
  EXPECT_NEAR(nearest, std::numbers::pi / 5 * 2, 1e-9);  // 72 degrees
}

TEST(PointPairs, ThreePairsGiveThePose) {
  const Pose T = test::some_pose();
  std::vector<PointPair> pairs;
  for (const Eigen::Vector3d& p :
       {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0.1, 0, 0), Eigen::Vector3d(0, 0.07, 0.02)}) {
    pairs.push_back({p, T * p});
  }
  const auto found = fit_pairs(pairs);
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->isApprox(T, 1e-12));
}

TEST(PointPairs, AreReadFromLines) {
  const auto pairs = parse_point_pairs("# mesh, reference\n1 2 3  4 5 6\n\n1e-1,0,0, 0,0,-2.5 # the corner\n");
  ASSERT_TRUE(pairs) << pairs.error().text();
  ASSERT_EQ(pairs->size(), 2u);
  EXPECT_EQ((*pairs)[0].on_reference, Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ((*pairs)[1].on_mesh, Eigen::Vector3d(0.1, 0, 0));
}

TEST(PointPairs, WrongLinesAreNamed) {
  for (const char* text :
       {"1 2 3 4 5 6\n1 2 3\n", "\n1 2 3 4 5 x", "\n1 2 3 4 5 nan", "\n1 2 3 4 5 6 7", "\n1 2 3 4 5 1e999"}) {
    const auto pairs = parse_point_pairs(text);
    ASSERT_FALSE(pairs) << text;
    EXPECT_EQ(pairs.error().code, ErrorCode::kInput);
    EXPECT_NE(pairs.error().message.find("line 2"), std::string::npos) << pairs.error().message;
  }
}

TEST(PointPairs, TooFewOrOnOneLineAreRefused) {
  EXPECT_FALSE(fit_pairs({}));
  EXPECT_FALSE(fit_pairs({{{0, 0, 0}, {0, 0, 0}}, {{1, 0, 0}, {1, 0, 0}}}));
  EXPECT_FALSE(fit_pairs({{{0, 0, 0}, {0, 0, 0}}, {{1, 0, 0}, {1, 0, 0}}, {{2, 0, 0}, {2, 0, 0}}}));
  EXPECT_FALSE(fit_pairs({{{0, 0, 0}, {0, 0, 0}}, {{0, 0, 0}, {0, 0, 0}}, {{0, 0, 0}, {0, 0, 0}}}));
}

TEST(RigidMatrix, IsReadAndAnythingElseRefused) {
  const auto read = parse_rigid_matrix("0 -1 0 10\n1 0 0 20\n0 0 1 30\n0 0 0 1\n", 0.001);
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_TRUE((*read * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(0.01, 1.02, 0.03)));
  for (const char* text : {"", "1 0 0 0", "2 0 0 0 0 2 0 0 0 0 2 0 0 0 0 1", "-1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1",
                           "0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0", "1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 1"}) {
    EXPECT_FALSE(parse_rigid_matrix(text, 1)) << text;
  }
}

}  // namespace
}  // namespace scanknit
