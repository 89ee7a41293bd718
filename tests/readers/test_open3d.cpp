// Open3D's Python module. It keeps what a file says: neither axes nor colours are converted.
#include <gtest/gtest.h>

#include "tests/readers/told_mesh.h"
#include "tests/support/places.h"

namespace scanknit::test {
namespace {

Said read_in_open3d(const WrittenMesh& file) {
  return run(debian_python() + " " + kSourceDir + "/tests/readers/read_in_open3d.py '" + file.path() + "' '" +
             file.json() + "'");
}

std::string seen_by_open3d(const std::string& name, const Expected& expected, const ExportConfig& config = {}) {
  const Mesh mesh = jack();
  const WrittenMesh file(mesh, name, config);
  const Said said = read_in_open3d(file);
  if (said.exit_code != 0) return said.text;
  return differences(told_in_json(file.json()), mesh, expected);
}

class Open3d : public ::testing::Test {
 protected:
  void SetUp() override {
    if (run(debian_python() + " -c 'import open3d'").exit_code != 0) {
      GTEST_SKIP() << "SKIPPED: Open3D is not installed (Debian package python3-open3d)";
    }
  }
};

TEST_F(Open3d, ReadsGlbUprightInMetresWithLinearColours) {
  EXPECT_EQ(seen_by_open3d("m.glb", {.R_told_world = y_up(), .colour = ToldColour::kLinear}), "");
}

TEST_F(Open3d, ReadsTheTextureAndItsCoordinates) {
  const Mesh mesh = jack();
  const TexturedFile textured(mesh);
  const Said said = read_in_open3d(textured.file());
  ASSERT_EQ(said.exit_code, 0) << said.text;
  EXPECT_EQ(
      differences(told_in_json(textured.file().json()), mesh, {.R_told_world = y_up(), .colour = ToldColour::kSrgb}),
      "");
}

TEST_F(Open3d, ReadsEveryPrimitive) {
  const Mesh mesh = jack();
  const std::size_t count = vertices_in_primitives(mesh);
  EXPECT_EQ(
      seen_by_open3d("m.glb", {.R_told_world = y_up(), .colour = ToldColour::kLinear, .count = count}, in_primitives()),
      "");
  const TexturedFile textured(mesh, in_primitives());
  const Said said = read_in_open3d(textured.file());
  ASSERT_EQ(said.exit_code, 0) << said.text;
  EXPECT_EQ(differences(told_in_json(textured.file().json()), mesh,
                        {.R_told_world = y_up(), .colour = ToldColour::kSrgb, .count = count}),
            "");
}

TEST_F(Open3d, ReadsPlyAsTheRecordingsWorldWithTheCamerasBytes) {
  EXPECT_EQ(seen_by_open3d("m.ply", {.R_told_world = as_it_is(), .colour = ToldColour::kSrgb}), "");
}

TEST_F(Open3d, ReadsObjAsTheRecordingsWorldWithTheCamerasBytes) {
  EXPECT_EQ(seen_by_open3d("m.obj", {.R_told_world = as_it_is(), .colour = ToldColour::kSrgb}), "");
}

TEST_F(Open3d, ReadsStlUprightInMillimetres) {
  EXPECT_EQ(seen_by_open3d(
                "m.stl",
                {.R_told_world = z_up(), .unit_m = 0.001, .colour = ToldColour::kNone, .vertices = ToldVertices::kAny}),
            "");
}

TEST_F(Open3d, ReadsNothingOfACompressedGlb) {
  ExportConfig config;
  config.compress = true;
  const WrittenMesh file(jack(), "m.glb", config);
  EXPECT_EQ(read_in_open3d(file).exit_code, 0);
  EXPECT_TRUE(told_in_json(file.json()).triangles.empty());
}

}  // namespace
}  // namespace scanknit::test
