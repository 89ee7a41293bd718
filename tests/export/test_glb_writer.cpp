// GLB files, taken apart with nothing but their specification.
#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "core/files/byte_reader.h"
#include "core/version.h"
#include "export/glb/glb_writer.h"
#include "export/mesh/write_mesh.h"
#include "tests/core/temporary_folder.h"
#include "tests/export/export_samples.h"

namespace scanknit {
namespace {

using test::TemporaryFolder;

struct Glb {
  std::uint32_t header_length = 0;
  std::size_t file_bytes = 0;
  nlohmann::json json;
  std::string binary;

  [[nodiscard]] const nlohmann::json& primitive() const { return json["meshes"][0]["primitives"][0]; }
  [[nodiscard]] const nlohmann::json& accessor(const char* attribute) const {
    return json["accessors"][primitive()["attributes"][attribute].get<std::size_t>()];
  }
  template <typename T>
  [[nodiscard]] T value(const nlohmann::json& accessor, std::size_t index) const {
    const auto& view = json["bufferViews"][accessor["bufferView"].get<std::size_t>()];
    T result;
    std::memcpy(&result, binary.data() + view.value("byteOffset", 0) + index * sizeof(T), sizeof(T));
    return result;
  }
};

Glb parse(const std::string& bytes) {
  Glb glb;
  glb.file_bytes = bytes.size();
  ByteReader reader(std::as_bytes(std::span(bytes)));
  EXPECT_EQ(reader.little_endian<std::uint32_t>(), 0x46546C67u);
  EXPECT_EQ(reader.little_endian<std::uint32_t>(), 2u);
  glb.header_length = reader.little_endian<std::uint32_t>().value();
  const auto json_bytes = reader.little_endian<std::uint32_t>().value();
  EXPECT_EQ(reader.little_endian<std::uint32_t>(), 0x4E4F534Au);
  glb.json = nlohmann::json::parse(bytes.substr(reader.offset(), json_bytes));
  EXPECT_TRUE(reader.take(json_bytes));
  const auto binary_bytes = reader.little_endian<std::uint32_t>().value();
  EXPECT_EQ(reader.little_endian<std::uint32_t>(), 0x004E4942u);
  glb.binary = bytes.substr(reader.offset(), binary_bytes);
  return glb;
}

Glb written(const Mesh& mesh, const ExportConfig& config = {}) {
  const TemporaryFolder folder;
  EXPECT_TRUE(write_mesh(mesh, folder / "m.glb", config, UpAxis::kY));
  return parse(test::read_text(folder / "m.glb"));
}

TEST(GlbWriter, HeaderLengthIsTheFilesLength) {
  const Glb glb = written(test::small_mesh());
  EXPECT_EQ(glb.header_length, glb.file_bytes);
}

TEST(GlbWriter, ColoursAreLinearSixteenBitWithFullAlpha) {
  Mesh mesh = test::tetrahedron();
  mesh.colours.assign(4, Rgb8{200, 60, 40});
  const Glb glb = written(mesh);
  const auto& accessor = glb.accessor("COLOR_0");
  EXPECT_EQ(accessor["componentType"], 5123);
  EXPECT_EQ(accessor["type"], "VEC4");
  EXPECT_EQ(accessor["normalized"], true);
  // 65535 x the linear light of 200, 60 and 40: .577580, .045186, .021219 (IEC 61966-2-1).
  EXPECT_EQ((glb.value<std::array<std::uint16_t, 4>>(accessor, 3)),
            (std::array<std::uint16_t, 4>{37852, 2961, 1391, 65535}));
}

TEST(GlbWriter, BoundsAreExactlyTheStoredFloats) {
  const Mesh mesh = test::small_mesh();
  const Glb glb = written(mesh);
  const auto& accessor = glb.accessor("POSITION");
  const MeshCheck check = check_mesh(mesh);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(accessor["min"][static_cast<std::size_t>(axis)].get<double>(), static_cast<double>(check.min_m[axis]));
    EXPECT_EQ(accessor["max"][static_cast<std::size_t>(axis)].get<double>(), static_cast<double>(check.max_m[axis]));
  }
}

TEST(GlbWriter, IndicesAreThirtyTwoBit) {
  const Glb glb = written(test::tetrahedron());
  const auto& accessor = glb.json["accessors"][glb.primitive()["indices"].get<std::size_t>()];
  EXPECT_EQ(accessor["componentType"], 5125);
  EXPECT_EQ((glb.value<Triangle>(accessor, 1)), test::tetrahedron().triangles[1]);
}

TEST(GlbWriter, BufferViewsNameTheirTargets) {
  const Glb glb = written(test::small_mesh());
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(glb.json["bufferViews"][i]["target"], i < 3 ? 34962 : 34963);
}

TEST(GlbWriter, MaterialIsNeverMetal) {
  for (const Mesh& mesh : {test::tetrahedron(), test::small_mesh()}) {
    const Glb glb = written(mesh);
    EXPECT_EQ(glb.json["materials"][0]["pbrMetallicRoughness"]["metallicFactor"], 0.0);
    EXPECT_EQ(glb.json["materials"][0]["pbrMetallicRoughness"].value("roughnessFactor", 1.0), 1.0);
    EXPECT_EQ(glb.primitive()["material"], 0);
  }
}

TEST(GlbWriter, LitUsesNoExtension) {
  EXPECT_FALSE(written(test::small_mesh()).json.contains("extensionsUsed"));
}

TEST(GlbWriter, UnlitIsDeclaredAndNotRequired) {
  ExportConfig config;
  config.material = Material::kUnlit;
  const Glb glb = written(test::small_mesh(), config);
  EXPECT_EQ(glb.json["extensionsUsed"], nlohmann::json::array({"KHR_materials_unlit"}));
  EXPECT_TRUE(glb.json["materials"][0]["extensions"]["KHR_materials_unlit"].is_object());
  EXPECT_FALSE(glb.json.contains("extensionsRequired"));
}

TEST(GlbWriter, SaysWhoWroteItAndInWhichUnit) {
  const Glb glb = written(test::small_mesh());
  EXPECT_EQ(glb.json["asset"]["generator"], std::string("ScanKnit ") + kVersion);
  EXPECT_EQ(glb.json["asset"]["extras"]["units"], "metre");
}

// The same mesh gives the same bytes in every version; the binary data is what the other tests look at.
TEST(GlbWriter, APlainDocumentHasSortedKeysAndLeavesOutWhatGltfAssumes) {
  Mesh mesh = test::tetrahedron();
  mesh.normals.clear();
  mesh.colours.clear();
  const TemporaryFolder folder;
  ASSERT_TRUE(write_mesh(mesh, folder / "m.glb", {}, UpAxis::kY));
  const std::string bytes = test::read_text(folder / "m.glb");
  std::string document = bytes.substr(20, bytes.find("BIN") - 24);
  document.resize(document.find_last_of('}') + 1);  // spaces fill it up
  EXPECT_EQ(document,
            std::string(R"({"accessors":[{"bufferView":0,"componentType":5126,"count":4,"max":[1.0,1.0,1.0],)"
                        R"("min":[0.0,0.0,0.0],"type":"VEC3"},{"bufferView":1,"componentType":5125,"count":12,)"
                        R"("type":"SCALAR"}],"asset":{"extras":{"units":"metre"},"generator":"ScanKnit )") +
                kVersion +
                R"(","version":"2.0"},"bufferViews":[{"buffer":0,"byteLength":48,"target":34962},)"
                R"({"buffer":0,"byteLength":48,"byteOffset":48,"target":34963}],"buffers":[{"byteLength":96}],)"
                R"("materials":[{"pbrMetallicRoughness":{"metallicFactor":0.0}}],"meshes":[{"primitives":)"
                R"([{"attributes":{"POSITION":0},"indices":1,"material":0,"mode":4}]}],"nodes":[{"mesh":0}],)"
                R"("scene":0,"scenes":[{"nodes":[0]}]})");
}

TEST(GlbWriter, UnknownNormalsAreStillUnitVectors) {
  Mesh mesh = test::small_mesh();
  mesh.normals[2].setZero();
  mesh.normals[3] *= 7;
  const Glb glb = written(mesh);
  constexpr float kRounding = 1e-6f;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto n = glb.value<std::array<float, 3>>(glb.accessor("NORMAL"), i);
    EXPECT_NEAR(std::hypot(n[0], n[1], n[2]), 1, kRounding);
  }
}

TEST(GlbWriter, TooLargeAMeshIsRefusedWithAWayOut) {
  const TemporaryFolder folder;
  auto file = AtomicFile::create(folder / "m.glb");
  ASSERT_TRUE(file);
  const Mesh mesh = test::cube();
  const Placement as_it_is;
  const auto refused = write_glb({mesh, as_it_is}, {}, *file, /*max_bytes=*/100);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kOutput);
  EXPECT_NE(refused.error().message.find("write PLY"), std::string::npos);
}

}  // namespace
}  // namespace scanknit
