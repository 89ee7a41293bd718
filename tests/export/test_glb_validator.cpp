// Khronos' own validator on what we write. Needs node, and `npm ci` of tests/package.json into build/npm.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <vector>

#include "core/picture/jpeg_codec.h"
#include "core/picture/png_codec.h"
#include "export/mesh/write_mesh.h"
#include "export/placement_plan.h"
#include "export/texture/mesh_texture.h"
#include "export/tiles/write_tiles.h"
#include "tests/core/temporary_folder.h"
#include "tests/export/texture_samples.h"
#include "tests/support/places.h"

namespace scanknit {
namespace {

using test::TemporaryFolder;

constexpr int kSkipped = 77;
constexpr int kNoSuchCommand = 127;

struct Verdict {
  int exit_code = 0;
  std::string issues;
};

Verdict validate(const std::filesystem::path& file) {
  const std::string command = "node '" + test::kSourceDir + "/tests/export/validate_glb.mjs' '" + test::kNpmDir +
                              "' '" + file.string() + "' 2>&1";
  Verdict verdict;
  FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) return {kNoSuchCommand, {}};
  std::array<char, 4096> block{};
  while (std::fgets(block.data(), static_cast<int>(block.size()), pipe) != nullptr) verdict.issues += block.data();
  const int status = ::pclose(pipe);
  verdict.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 1;
  return verdict;
}

/// `remarks`: beginnings of those, neither errors nor warnings, that there may be.
void expect_valid(const Mesh& mesh, const ExportConfig& config, const std::vector<std::string>& remarks = {},
                  const MeshTexture* texture = nullptr) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_mesh(mesh, folder / "m.glb", config, UpAxis::kMinusY, std::nullopt, texture));
  const Verdict verdict = validate(folder / "m.glb");
  if (verdict.exit_code == kSkipped || verdict.exit_code == kNoSuchCommand) {
    GTEST_SKIP() << "SKIPPED: node or gltf-validator is not installed (npm ci in " << test::kNpmDir << ")";
  }
  EXPECT_EQ(verdict.exit_code, 0) << verdict.issues;
  std::istringstream lines(verdict.issues);
  for (std::string line; std::getline(lines, line);) {
    const auto begins_line = [&line](const std::string& remark) { return line.starts_with(remark); };
    EXPECT_TRUE(std::any_of(remarks.begin(), remarks.end(), begins_line)) << line;
  }
}

void expect_valid(const Mesh& mesh, Material material) {
  ExportConfig config;
  config.material = material;
  expect_valid(mesh, config);
}

TEST(GlbValidator, FindsNothingInAQuantizedMesh) {
  ExportConfig config;
  config.quantize = true;
  expect_valid(test::marked_sphere(), config);
  config.material = Material::kUnlit;
  expect_valid(test::small_mesh(), config);
  expect_valid(test::tetrahedron(), config);
}

// It does not know the extension, and says so; what is compressed it does not look into, and takes for unused.
TEST(GlbValidator, FindsNothingWrongInACompressedMesh) {
  for (const bool is_quantized : {false, true}) {
    ExportConfig config;
    config.compress = true;
    config.quantize = is_quantized;
    expect_valid(test::marked_sphere(), config,
                 {"UNSUPPORTED_EXTENSION", "UNUSED_OBJECT (severity 2): This object may be unused. /buffers/0"});
  }
}

// Sizes that are no powers of two it remarks on: the first WebGL had no mipmaps of them.
TEST(GlbValidator, FindsNothingWrongInATexturedMesh) {
  Mesh sphere = test::sphere();
  const TextureAtlas atlas = test::atlas_of(sphere, 0.02);
  const Mesh mesh = atlas.unfolded(sphere);
  MeshTexture texture;
  for (std::size_t v = 0; v < atlas.source.size(); ++v) texture.coordinates.push_back(atlas.coordinate(v));
  const ColourImage image(atlas.width, atlas.height, Rgb8{10, 200, 30});
  for (const bool is_png : {true, false}) {
    texture.image = is_png ? *encode_png(image, PngEffort::kFast) : *encode_jpeg(image, 92);
    texture.mime = is_png ? "image/png" : "image/jpeg";
    for (const bool is_quantized : {false, true}) {
      ExportConfig config;
      config.material = is_png ? Material::kLit : Material::kUnlit;
      config.quantize = is_quantized;
      expect_valid(mesh, config, {"IMAGE_NPOT_DIMENSIONS"}, &texture);
      config.compress = true;
      expect_valid(mesh, config, {"IMAGE_NPOT_DIMENSIONS", "UNSUPPORTED_EXTENSION", "UNUSED_OBJECT (severity 2)"},
                   &texture);
    }
  }
}

TEST(GlbValidator, FindsNothingWrongInAMeshOfSeveralPrimitives) {
  const Mesh sphere = test::marked_sphere();
  const test::OwnTexels texels = test::own_texels(sphere);
  Mesh uncoloured = sphere;
  uncoloured.colours.clear();
  for (int packing = 0; packing < 4; ++packing) {
    ExportConfig config;
    config.max_vertices_of_a_primitive = 500;
    config.quantize = (packing & 1) != 0;
    config.compress = (packing & 2) != 0;
    std::vector<std::string> remarks;
    if (config.compress) remarks = {"UNSUPPORTED_EXTENSION", "UNUSED_OBJECT (severity 2)"};
    expect_valid(sphere, config, remarks);
    remarks.emplace_back("IMAGE_NPOT_DIMENSIONS");
    expect_valid(uncoloured, config, remarks, &texels.texture);
  }
}

TEST(GlbValidator, FindsNothingInTiles) {
  const TemporaryFolder folder;
  const ExportConfig config;
  const PlacementPlan plan = plan_placement(MeshFormat::kTiles, config, UpAxis::kZ, std::nullopt);
  ASSERT_TRUE(write_tiles(test::marked_sphere(), plan, config, folder / "m.tiles", 2000));
  int tiles = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "m.tiles")) {
    if (entry.path().extension() != ".glb") continue;
    const Verdict verdict = validate(entry.path());
    if (verdict.exit_code == kSkipped || verdict.exit_code == kNoSuchCommand) {
      GTEST_SKIP() << "SKIPPED: node or gltf-validator is not installed (npm ci in " << test::kNpmDir << ")";
    }
    EXPECT_EQ(verdict.issues, "") << entry.path();
    ++tiles;
  }
  EXPECT_EQ(tiles, 9);  // a root, and the eight octants
}

TEST(GlbValidator, FindsNothingInALitMesh) {
  expect_valid(test::marked_sphere(), Material::kLit);
}

TEST(GlbValidator, FindsNothingInAnUnlitMesh) {
  expect_valid(test::marked_sphere(), Material::kUnlit);
}

TEST(GlbValidator, FindsNothingInAMeshWithoutColours) {
  expect_valid(test::sphere(), Material::kLit);
}

TEST(GlbValidator, FindsNothingInAMeshWithoutNormals) {
  Mesh mesh = test::marked_sphere();
  mesh.normals.clear();
  expect_valid(mesh, Material::kLit);
}

TEST(GlbValidator, FindsNothingInABareMesh) {
  expect_valid(test::tetrahedron(), Material::kUnlit);
}

TEST(GlbValidator, FindsNothingInUnknownNormals) {
  Mesh mesh = test::small_mesh();
  mesh.normals[1].setZero();
  expect_valid(mesh, Material::kLit);
}

}  // namespace
}  // namespace scanknit
