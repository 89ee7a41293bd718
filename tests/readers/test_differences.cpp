// What the readers' tests rest on: whatever is wrong with a mesh is seen.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

#include "tests/readers/reader_sample.h"

namespace scanknit::test {
namespace {

ToldMesh as_told(const Mesh& mesh) {
  ToldMesh told;
  for (const auto& p : mesh.positions_m) told.positions.emplace_back(p.cast<double>());
  for (const Rgb8& c : mesh.colours) told.colours.emplace_back(c.r, c.g, c.b);
  told.triangles = mesh.triangles;
  return told;
}

/// What differences() says of the jack after `damage`, seen as `expected`.
template <typename Damage>
std::string said_of(Damage damage, const Expected& expected = {}) {
  const Mesh mesh = jack();
  ToldMesh told = as_told(mesh);
  damage(told);
  return differences(told, mesh, expected);
}

TEST(ReaderCheck, TheJackIsClosedAndEachOfItsVerticesAndColoursIsItsOwn) {
  const Mesh mesh = jack();
  const MeshCheck check = check_mesh(mesh);
  EXPECT_TRUE(check.is_closed() && check.is_manifold());
  EXPECT_EQ(check.euler, 2);
  EXPECT_EQ(check.degenerate_triangles, 0u);
  std::set<std::tuple<long, long, long>> places, colours;
  for (const auto& p : mesh.positions_m) {
    places.emplace(std::lround(1e5f * p.x()), std::lround(1e5f * p.y()), std::lround(1e5f * p.z()));
  }
  for (const Rgb8& c : mesh.colours) colours.emplace(c.r, c.g, c.b);
  EXPECT_EQ(places.size(), mesh.positions_m.size());
  EXPECT_EQ(colours.size(), mesh.positions_m.size());
}

TEST(ReaderCheck, FindsNothingInTheMeshItselfInAnyOrder) {
  EXPECT_EQ(said_of([](ToldMesh&) {}), "");
  EXPECT_EQ(said_of([](ToldMesh& told) {
              std::reverse(told.triangles.begin(), told.triangles.end());
              for (Triangle& t : told.triangles) std::rotate(t.begin(), t.begin() + 1, t.end());
            }),
            "");
}

TEST(ReaderCheck, FindsSwappedAxesAndMirrors) {
  for (const auto& [a, b] : {std::pair{0, 1}, std::pair{1, 2}, std::pair{0, 2}}) {
    EXPECT_NE(said_of([a = a, b = b](ToldMesh& told) {
                for (auto& p : told.positions) std::swap(p[a], p[b]);
              }),
              "");
  }
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NE(said_of([axis](ToldMesh& told) {
                for (auto& p : told.positions) p[axis] = -p[axis];
              }),
              "");
  }
}

TEST(ReaderCheck, FindsAnotherUnitAndAHundredthOfAMillimetre) {
  EXPECT_NE(said_of([](ToldMesh& told) {
              for (auto& p : told.positions) p *= 1000;
            }),
            "");
  EXPECT_NE(said_of([](ToldMesh& told) { told.positions[7].z() += 1e-5; }), "");
  Expected in_mm;
  in_mm.unit_m = 0.001;
  EXPECT_NE(said_of([](ToldMesh&) {}, in_mm), "");
}

TEST(ReaderCheck, FindsATriangleTurnedRoundAndOneThatIsAnother) {
  EXPECT_NE(said_of([](ToldMesh& told) { std::swap(told.triangles[3][0], told.triangles[3][1]); }), "");
  EXPECT_NE(said_of([](ToldMesh& told) { told.triangles[3] = told.triangles[4]; }), "");
  EXPECT_NE(said_of([](ToldMesh& told) { told.triangles.pop_back(); }), "");
}

TEST(ReaderCheck, FindsOneColourOffByOneAndLightTakenForAnEncoding) {
  EXPECT_NE(said_of([](ToldMesh& told) { told.colours[5].y() += 1; }), "");
  EXPECT_NE(said_of([](ToldMesh& told) { std::swap(told.colours[5], told.colours[6]); }), "");
  EXPECT_NE(said_of([](ToldMesh& told) { told.colours.clear(); }), "");
  Expected linear, none;
  linear.colour = ToldColour::kLinear;
  none.colour = ToldColour::kNone;
  EXPECT_NE(said_of([](ToldMesh&) {}, linear), "");
  EXPECT_NE(said_of([](ToldMesh&) {}, none), "");
}

TEST(ReaderCheck, FindsVerticesThatWereSplit) {
  EXPECT_NE(said_of([](ToldMesh& told) {
              told.triangles[0][0] = static_cast<std::uint32_t>(told.positions.size());
              told.positions.push_back(told.positions[jack().triangles[0][0]]);
              told.colours.push_back(told.colours[jack().triangles[0][0]]);
            }),
            "");
}

}  // namespace
}  // namespace scanknit::test
