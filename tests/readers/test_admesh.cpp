// ADMesh, which repairs STL files for printers: it must find nothing to repair.
#include <gtest/gtest.h>

#include <sstream>

#include "tests/readers/told_mesh.h"

namespace scanknit::test {
namespace {

/// The number behind `label`, in the column `column` of those in its line; -1 where there is none.
double number_in(const std::string& text, const std::string& label, int column = 0) {
  const std::size_t at = text.find(label);
  if (at == std::string::npos) return -1;
  std::istringstream numbers(text.substr(text.find(':', at) + 1));
  double number = -1;
  for (int i = 0; i <= column; ++i) {
    if (!(numbers >> number)) return -1;
  }
  return number;
}

/// What ADMesh says of a mesh; its checks of every kind are on.
std::string said_by_admesh(const Mesh& mesh) {
  const Said said = run("LC_ALL=C admesh '" + WrittenMesh(mesh, "m.stl").path() + "'");
  EXPECT_EQ(said.exit_code, 0) << said.text;
  return said.text;
}

class Admesh : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!has_command("admesh")) GTEST_SKIP() << "SKIPPED: admesh is not installed (Debian package admesh)";
  }
};

TEST_F(Admesh, FindsNothingToRepair) {
  const Mesh mesh = jack();
  const std::string said = said_by_admesh(mesh);
  for (const int column : {0, 1}) EXPECT_EQ(number_in(said, "Number of facets", column), mesh.triangles.size()) << said;
  EXPECT_EQ(number_in(said, "Total disconnected facets"), 0) << said;
  EXPECT_EQ(number_in(said, "Number of parts"), 1) << said;
  for (const char* label : {"Degenerate facets", "Edges fixed", "Facets removed", "Facets added", "Facets reversed",
                            "Backwards edges", "Normals fixed"}) {
    EXPECT_EQ(number_in(said, label), 0) << label << "\n" << said;
  }
}

TEST_F(Admesh, FindsTheVolumeInCubicMillimetres) {
  constexpr double kOfFloats = 1e-4;  // it adds up in single precision
  const Mesh mesh = jack();
  const std::string said = said_by_admesh(mesh);
  const double volume_mm3 = 1e9 * signed_volume_m3(mesh);
  ASSERT_GT(volume_mm3, 0);
  EXPECT_NEAR(number_in(said, "Volume  "), volume_mm3, kOfFloats * volume_mm3) << said;
}

/// That it does find what is wrong.
TEST_F(Admesh, RepairsAHole) {
  Mesh mesh = jack();
  mesh.triangles.pop_back();
  const std::string said = said_by_admesh(mesh);
  EXPECT_EQ(number_in(said, "Total disconnected facets"), 3) << said;
  EXPECT_EQ(number_in(said, "Facets added"), 1) << said;
}

TEST_F(Admesh, RepairsATriangleTurnedRound) {
  Mesh mesh = jack();
  std::swap(mesh.triangles[1000][0], mesh.triangles[1000][1]);
  const std::string said = said_by_admesh(mesh);
  EXPECT_EQ(number_in(said, "Facets reversed"), 1) << said;
}

}  // namespace
}  // namespace scanknit::test
