// assimp, by its command. It keeps what a file says: neither axes nor colours are converted.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/readers/told_mesh.h"

namespace scanknit::test {
namespace {

using nlohmann::json;

/// Its JSON has six digits.
constexpr double kSixDigitsM = 6e-6;

/// The texel at each vertex's coordinates, whose rows count from below.
void add_texels(const json& mesh, const ColourImage& picture, ToldMesh& told) {
  ASSERT_EQ(mesh.at("numuvcomponents").at(0), 2);
  const json& uv = mesh.at("texturecoords").at(0);
  for (std::size_t i = 0; i + 1 < uv.size(); i += 2) {
    const int x = static_cast<int>(uv[i].get<double>() * picture.width());
    const int y = static_cast<int>((1 - uv[i + 1].get<double>()) * picture.height());
    ASSERT_TRUE(picture.contains(x, y));
    const Rgb8 texel = picture.at(x, y);
    told.colours.emplace_back(texel.r, texel.g, texel.b);
  }
}

/// The file of the material's base colour; *0 is the first picture inside.
std::string base_colour_file(const json& material) {
  constexpr int kBaseColour = 12;  // aiTextureType_BASE_COLOR
  for (const json& property : material.at("properties")) {
    if (property.at("key") == "$tex.file" && property.at("semantic") == kBaseColour) return property.at("value");
  }
  return "";
}

/// The meshes of a node and of those below it, at their places.
void add_node(const json& scene, const json& node, const Eigen::Matrix4d& T_scene_parent, ToldMesh& told,
              const ColourImage* picture = nullptr) {
  Eigen::Matrix4d T_parent_node;
  for (int i = 0; i < 16; ++i) T_parent_node(i / 4, i % 4) = node.at("transformation").at(static_cast<std::size_t>(i));
  const Eigen::Matrix4d T_scene_node = T_scene_parent * T_parent_node;
  for (const auto& number : node.value("meshes", json::array())) {
    const json& mesh = scene.at("meshes").at(number.get<std::size_t>());
    const auto first = static_cast<std::uint32_t>(told.positions.size());
    const auto& v = mesh.at("vertices");
    for (std::size_t i = 0; i < v.size(); i += 3) {
      told.positions.emplace_back((T_scene_node * Eigen::Vector4d(v[i], v[i + 1], v[i + 2], 1)).head<3>());
    }
    for (const auto& f : mesh.at("faces")) {
      ASSERT_EQ(f.size(), 3u);
      told.triangles.emplace_back(first + f[0].get<std::uint32_t>(), first + f[1].get<std::uint32_t>(),
                                  first + f[2].get<std::uint32_t>());
    }
    if (picture != nullptr) add_texels(mesh, *picture, told);
    if (!mesh.contains("colors")) continue;
    const json& c = mesh["colors"].at(0);
    for (std::size_t i = 0; i < c.size(); i += 4) {
      told.colours.emplace_back(255 * Eigen::Vector3d(c[i], c[i + 1], c[i + 2]));
    }
  }
  for (const auto& child : node.value("children", json::array())) add_node(scene, child, T_scene_node, told, picture);
}

std::string seen_by_assimp(const std::string& name, Expected expected, const ExportConfig& config = {}) {
  const Mesh mesh = jack();
  const WrittenMesh file(mesh, name, config);
  const Said exported = run("assimp export '" + file.path() + "' '" + file.json() + "' -fassjson");
  if (exported.exit_code != 0) return exported.text;
  const json scene = json::parse(std::ifstream(file.json()));
  ToldMesh told;
  add_node(scene, scene.at("rootnode"), Eigen::Matrix4d::Identity(), told);
  expected.tolerance_m = kSixDigitsM;
  return differences(told, mesh, expected);
}

std::string texture_seen_by_assimp(const TexturedFile& textured, const Mesh& mesh, Expected expected) {
  const WrittenMesh& file = textured.file();
  const Said exported = run("assimp export '" + file.path() + "' '" + file.json() + "' -fassjson");
  if (exported.exit_code != 0) return exported.text;
  const json scene = json::parse(std::ifstream(file.json()));
  EXPECT_EQ(base_colour_file(scene.at("materials").at(0)), "*0");
  ToldMesh told;
  add_node(scene, scene.at("rootnode"), Eigen::Matrix4d::Identity(), told, &textured.image());
  expected.R_told_world = y_up();
  expected.colour = ToldColour::kSrgb;
  expected.tolerance_m = kSixDigitsM;
  return differences(told, mesh, expected);
}

/// The number behind `label`; 0 where there is none.
std::size_t count_in(const std::string& text, const std::string& label) {
  const std::size_t at = text.find(label);
  return at == std::string::npos ? 0 : std::stoul(text.substr(at + label.size()));
}

class Assimp : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!has_command("assimp")) GTEST_SKIP() << "SKIPPED: assimp is not installed (Debian package assimp-utils)";
  }
};

TEST_F(Assimp, ReadsGlbUprightInMetresWithLinearColours) {
  EXPECT_EQ(seen_by_assimp("m.glb", {.R_told_world = y_up(), .colour = ToldColour::kLinear}), "");
}

TEST_F(Assimp, ReadsEveryPrimitive) {
  const Mesh mesh = jack();
  const std::size_t count = vertices_in_primitives(mesh);
  EXPECT_EQ(
      seen_by_assimp("m.glb", {.R_told_world = y_up(), .colour = ToldColour::kLinear, .count = count}, in_primitives()),
      "");
  const TexturedFile textured(mesh, in_primitives());
  EXPECT_EQ(texture_seen_by_assimp(textured, mesh, {.count = count}), "");
}

TEST_F(Assimp, ReadsTheTextureAndItsCoordinates) {
  const Mesh mesh = jack();
  const TexturedFile textured(mesh);
  EXPECT_EQ(texture_seen_by_assimp(textured, mesh, {}), "");

  const WrittenMesh& file = textured.file();
  const std::string stem = file.json();  // without its extension, and with _img0
  const Said extracted = run("assimp extract '" + file.path() + "' '" + stem + ".png'");
  ASSERT_EQ(extracted.exit_code, 0) << extracted.text;
  const std::string picture = test::read_text(stem + "_img0.png");
  EXPECT_TRUE(std::equal(picture.begin(), picture.end(), textured.picture_file().begin(), textured.picture_file().end(),
                         [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; }));
}

TEST_F(Assimp, ReadsPlyAsTheRecordingsWorldWithTheCamerasBytes) {
  EXPECT_EQ(seen_by_assimp("m.ply", {.colour = ToldColour::kSrgb}), "");
}

TEST_F(Assimp, ReadsObjAsTheRecordingsWorldWithTheCamerasBytes) {
  EXPECT_EQ(seen_by_assimp("m.obj", {.colour = ToldColour::kSrgb, .vertices = ToldVertices::kSeparate}), "");
}

TEST_F(Assimp, ReadsStlUprightInMillimetres) {
  EXPECT_EQ(
      seen_by_assimp(
          "m.stl",
          {.R_told_world = z_up(), .unit_m = 0.001, .colour = ToldColour::kNone, .vertices = ToldVertices::kSeparate}),
      "");
}

/// Its version 5.2 knows nothing of colour groups.
TEST_F(Assimp, Reads3mfUprightInMillimetresWithoutColours) {
  EXPECT_EQ(seen_by_assimp("m.3mf", {.R_told_world = z_up(), .unit_m = 0.001, .colour = ToldColour::kNone}), "");
}

TEST_F(Assimp, RefusesACompressedGlb) {
  ExportConfig config;
  config.compress = true;
  EXPECT_NE(run("assimp info '" + WrittenMesh(jack(), "m.glb", config).path() + "'").exit_code, 0);
}

/// What it says after its own validation, and after joining vertices that are the same in all they have. STL's have the
/// triangle's own normal and stay apart.
TEST_F(Assimp, InfoCountsTheSameInEveryFormat) {
  const Mesh mesh = jack();
  for (const char* name : {"m.glb", "m.ply", "m.obj", "m.stl", "m.3mf"}) {
    const Said said = run("assimp info '" + WrittenMesh(mesh, name).path() + "'");
    EXPECT_EQ(said.exit_code, 0) << name << ": " << said.text;
    EXPECT_EQ(count_in(said.text, "Faces:"), mesh.triangles.size()) << name << ": " << said.text;
    if (name == std::string("m.stl")) continue;
    EXPECT_EQ(count_in(said.text, "Vertices:"), mesh.positions_m.size()) << name << ": " << said.text;
  }
}

}  // namespace
}  // namespace scanknit::test
