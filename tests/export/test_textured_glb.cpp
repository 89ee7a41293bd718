// GLB files with a texture.
#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "export/mesh/mesh_extension.h"
#include "export/mesh/mesh_readers.h"
#include "export/mesh/write_mesh.h"
#include "tests/core/temporary_folder.h"
#include "tests/export/every_packing.h"
#include "tests/export/texture_samples.h"

namespace scanknit {
namespace {

using test::TemporaryFolder;

struct Chunks {
  nlohmann::json json;
  std::string binary;
};

Chunks chunks_of(const std::string& glb) {
  constexpr std::size_t kHead = 20, kChunkHead = 8;
  std::uint32_t length = 0;
  std::memcpy(&length, glb.data() + 12, sizeof(length));
  return {nlohmann::json::parse(glb.substr(kHead, length)), glb.substr(kHead + length + kChunkHead)};
}

class TexturedGlb : public test::EveryPacking {};

TEST_P(TexturedGlb, HoldsThePictureAndItsCoordinates) {
  const TemporaryFolder folder;
  const test::Textured made = test::textured(test::marked_sphere());
  const auto written = write_mesh(made.mesh, folder / "m.glb", config(), UpAxis::kY, std::nullopt, &made.texture);
  ASSERT_TRUE(written) << written.error().text();
  const std::string glb = test::read_text(folder / "m.glb");
  const auto [json, binary] = chunks_of(glb);
  const nlohmann::json& primitive = json["meshes"][0]["primitives"][0];
  EXPECT_FALSE(primitive["attributes"].contains("COLOR_0"));
  EXPECT_EQ(json["accessors"][primitive["attributes"]["TEXCOORD_0"].get<std::size_t>()]["count"],
            made.mesh.positions_m.size());
  EXPECT_EQ(json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"], 0);
  EXPECT_EQ(json["images"][0]["mimeType"], "image/png");
  const nlohmann::json& view = json["bufferViews"][json["images"][0]["bufferView"].get<std::size_t>()];
  EXPECT_EQ(view["buffer"], 0);  // also of a compressed file: this is the one with bytes
  const std::string picture =
      binary.substr(view["byteOffset"].get<std::size_t>(), view["byteLength"].get<std::size_t>());
  EXPECT_TRUE(picture == std::string(made.texture.image.begin(), made.texture.image.end()));
  const auto again = parse_mesh(glb, MeshFormat::kGlb, {});
  ASSERT_TRUE(again) << again.error().text();
  EXPECT_EQ(again->triangles.size(), made.mesh.triangles.size());
}

INSTANTIATE_TEST_SUITE_P(EveryPacking, TexturedGlb, ::testing::Range(0, 4));

TEST(TexturedGlbLimits, ATextureThatDoesNotFitTheMeshIsRefused) {
  const TemporaryFolder folder;
  test::Textured made = test::textured(test::marked_sphere());
  const auto error_of = [&] {
    const auto written = write_mesh(made.mesh, folder / "m.glb", {}, UpAxis::kY, std::nullopt, &made.texture);
    return written ? std::string() : written.error().message;
  };
  EXPECT_EQ(error_of(), "");
  made.texture.coordinates[3].x() = std::nanf("");
  EXPECT_NE(error_of(), "");
  made = test::textured(test::marked_sphere());
  made.texture.coordinates.pop_back();
  EXPECT_NE(error_of(), "");
  made = test::textured(test::marked_sphere());
  made.mesh.colours.resize(made.mesh.positions_m.size());  // viewers would multiply
  EXPECT_NE(error_of(), "");
}

}  // namespace
}  // namespace scanknit
