// Blender, by its own importers. Its world has z up: what has another axis up is turned on the way in.
#include <gtest/gtest.h>

#include "tests/readers/told_mesh.h"
#include "tests/support/places.h"

namespace scanknit::test {
namespace {

Said read_in_blender(const WrittenMesh& file) {
  return run("blender -b --factory-startup --python-exit-code 3 --python " + kSourceDir +
             "/tests/readers/read_in_blender.py -- '" + file.path() + "' '" + file.json() + "'");
}

std::string seen_by_blender(const std::string& name, const Expected& expected, const ExportConfig& config = {}) {
  const Mesh mesh = jack();
  const WrittenMesh file(mesh, name, config);
  const Said said = read_in_blender(file);
  if (said.exit_code != 0) return said.text;
  return differences(told_in_json(file.json()), mesh, expected);
}

class Blender : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!has_command("blender")) GTEST_SKIP() << "SKIPPED: blender is not installed (Debian package blender)";
  }
};

TEST_F(Blender, ReadsGlbUprightInMetresWithTheCamerasColours) {
  EXPECT_EQ(seen_by_blender("m.glb", {.R_told_world = z_up(), .colour = ToldColour::kLinear}), "");
}

TEST_F(Blender, ReadsAnUnlitGlb) {
  ExportConfig config;
  config.material = Material::kUnlit;
  EXPECT_EQ(seen_by_blender("m.glb", {.R_told_world = z_up(), .colour = ToldColour::kLinear}, config), "");
}

TEST_F(Blender, ReadsAQuantizedGlbToAStepOf65535OfItsLongestSide) {
  constexpr double kLongestSideM = 0.26;
  ExportConfig config;
  config.quantize = true;
  EXPECT_EQ(seen_by_blender(
                "m.glb", {.R_told_world = z_up(), .colour = ToldColour::kLinear, .tolerance_m = kLongestSideM / 65535},
                config),
            "");
}

std::string textured_in_blender(Expected expected, const ExportConfig& config = {}) {
  const Mesh mesh = jack();
  const TexturedFile textured(mesh, config);
  const Said said = read_in_blender(textured.file());
  if (said.exit_code != 0) return said.text;
  expected.R_told_world = z_up();
  return differences(told_in_json(textured.file().json()), mesh, expected);
}

TEST_F(Blender, ReadsTheTextureAsTheMaterialsBaseColour) {
  EXPECT_EQ(textured_in_blender({.colour = ToldColour::kSrgb}), "");
}

TEST_F(Blender, ReadsTheTextureOfAQuantizedGlb) {
  constexpr double kLongestSideM = 0.26;
  ExportConfig config;
  config.quantize = true;
  EXPECT_EQ(textured_in_blender({.colour = ToldColour::kSrgb, .tolerance_m = kLongestSideM / 65535}, config), "");
}

TEST_F(Blender, ReadsEveryPrimitiveIntoOneMesh) {
  const std::size_t count = vertices_in_primitives(jack());
  EXPECT_EQ(seen_by_blender("m.glb", {.R_told_world = z_up(), .colour = ToldColour::kLinear, .count = count},
                            in_primitives()),
            "");
  EXPECT_EQ(textured_in_blender({.colour = ToldColour::kSrgb, .count = count}, in_primitives()), "");
}

TEST_F(Blender, RefusesACompressedGlbAndSaysWhy) {
  ExportConfig config;
  config.compress = true;
  const Said said = read_in_blender(WrittenMesh(jack(), "m.glb", config));
  EXPECT_NE(said.exit_code, 0);
  EXPECT_NE(said.text.find("EXT_meshopt_compression"), std::string::npos) << said.text;
}

TEST_F(Blender, ReadsPlyAsTheRecordingsWorld) {
  EXPECT_EQ(seen_by_blender("m.ply", {.R_told_world = as_it_is(), .colour = ToldColour::kLinear}), "");
}

/// Y up written on purpose; Blender takes every OBJ for that and turns it.
TEST_F(Blender, ReadsObjUprightWhenItWasWrittenYUp) {
  ExportConfig config;
  config.up = UpAxis::kY;
  EXPECT_EQ(seen_by_blender("m.obj", {.R_told_world = z_up(), .colour = ToldColour::kLinear}, config), "");
}

TEST_F(Blender, ReadsStlUprightInMillimetresWelded) {
  EXPECT_EQ(seen_by_blender("m.stl", {.R_told_world = z_up(), .unit_m = 0.001, .colour = ToldColour::kNone}), "");
}

}  // namespace
}  // namespace scanknit::test
