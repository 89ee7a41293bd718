// Bytes that mean harm, or were cut short: every reader answers, none crashes.
#include <gtest/gtest.h>

#include <cstring>

#include "export/mesh/mesh_readers.h"
#include "export/mesh/write_mesh.h"
#include "tests/core/temporary_folder.h"
#include "tests/export/export_samples.h"

namespace scanknit {
namespace {

std::string file_of(const Mesh& mesh, const std::string& name) {
  const test::TemporaryFolder folder;
  EXPECT_TRUE(write_mesh(mesh, folder / name, {}, UpAxis::kY));
  return test::read_text(folder / name);
}

class Hostile : public ::testing::TestWithParam<const char*> {
 protected:
  [[nodiscard]] static MeshFormat format() { return *mesh_format(GetParam()); }
};
INSTANTIATE_TEST_SUITE_P(Format, Hostile, ::testing::Values("m.glb", "m.ply", "m.obj", "m.stl"));

TEST_P(Hostile, TruncatedAtAnyByteIsAnsweredAndWellFormed) {
  const std::string whole = file_of(test::small_mesh(), GetParam());
  for (std::size_t length = 0; length < whole.size(); ++length) {
    const auto mesh = parse_mesh(std::string_view(whole).substr(0, length), format(), {});
    if (mesh) {
      EXPECT_TRUE(check_mesh(*mesh).is_well_formed) << length;
    }
    if (format() != MeshFormat::kObj) {
      EXPECT_FALSE(mesh) << length;  // a cut OBJ is a shorter OBJ
    }
  }
}

TEST_P(Hostile, AnyByteChangedIsAnsweredAndWellFormed) {
  const std::string whole = file_of(test::small_mesh(), GetParam());
  for (std::size_t at = 0; at < whole.size(); ++at) {
    for (const int flip : {0x01, 0x10, 0x80, 0xFF}) {
      std::string changed = whole;
      changed[at] = static_cast<char>(changed[at] ^ flip);
      const auto mesh = parse_mesh(changed, format(), {});
      if (mesh) {
        EXPECT_TRUE(check_mesh(*mesh).is_well_formed) << at;
      }
    }
  }
}

TEST_P(Hostile, NoiseIsRefused) {
  std::string noise(4096, '\0');
  std::uint32_t state = 7;
  for (char& c : noise) {
    state = state * 1664525u + 1013904223u;
    c = static_cast<char>(state >> 24);
  }
  EXPECT_FALSE(parse_mesh(noise, format(), {}));
  EXPECT_FALSE(parse_mesh("", format(), {}));
}

/// A GLB of one JSON chunk and `binary`.
std::string glb_of(std::string json, const std::string& binary = std::string(64, '\0')) {
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const auto word = [](std::size_t value) {
    std::string bytes(4, '\0');
    const auto narrow = static_cast<std::uint32_t>(value);
    std::memcpy(bytes.data(), &narrow, 4);
    return bytes;
  };
  return "glTF" + word(2) + word(28 + json.size() + binary.size()) + word(json.size()) + "JSON" + json +
         word(binary.size()) + std::string("BIN\0", 4) + binary;
}

/// A scene of one triangle whose parts the tests replace.
std::string scene(const std::string& nodes = R"([{"mesh":0}])",
                  const std::string& accessor = R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"})",
                  const std::string& view = R"({"buffer":0,"byteLength":36})",
                  const std::string& primitive = R"({"attributes":{"POSITION":0}})", const std::string& extra = "") {
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":)" + nodes +
         R"(,"meshes":[{"primitives":[)" + primitive + R"(]}],"accessors":[)" + accessor + R"(],"bufferViews":[)" +
         view + R"(],"buffers":[{"byteLength":64}])" + extra + "}";
}

TEST(HostileGlb, TheHarmlessSceneIsRead) {
  const auto mesh = parse_mesh(glb_of(scene()), MeshFormat::kGlb, {});
  ASSERT_TRUE(mesh) << mesh.error().text();
  EXPECT_EQ(mesh->triangles.size(), 1u);
}

std::string refusal(const std::string& json) {
  const auto mesh = parse_mesh(glb_of(json), MeshFormat::kGlb, {});
  EXPECT_FALSE(mesh);
  return mesh ? "" : mesh.error().message;
}

TEST(HostileGlb, AccessorsStayInsideTheirBuffer) {
  const std::string nodes = R"([{"mesh":0}])";
  for (const char* accessor : {R"({"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"})",
                               R"({"bufferView":0,"componentType":5126,"count":4611686018427387904,"type":"VEC3"})",
                               R"({"bufferView":0,"byteOffset":4,"componentType":5126,"count":3,"type":"VEC3"})",
                               R"({"bufferView":0,"byteOffset":99999,"componentType":5126,"count":1,"type":"VEC3"})",
                               R"({"bufferView":7,"componentType":5126,"count":3,"type":"VEC3"})",
                               R"({"componentType":5126,"count":3,"type":"VEC3"})",
                               R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC2"})"}) {
    EXPECT_NE(refusal(scene(nodes, accessor)), "") << accessor;
  }
}

TEST(HostileGlb, BufferViewsStayInsideTheirBuffer) {
  const std::string accessor = R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"})";
  for (const char* view : {R"({"buffer":0,"byteOffset":40,"byteLength":36})", R"({"buffer":3,"byteLength":36})",
                           R"({"buffer":0,"byteOffset":18446744073709551600,"byteLength":36})",
                           R"({"buffer":0,"byteLength":36,"byteStride":252})"}) {
    EXPECT_NE(refusal(scene(R"([{"mesh":0}])", accessor, view)), "") << view;
  }
}

TEST(HostileGlb, NodesThatAreNoTreeAreRefused) {
  EXPECT_NE(refusal(scene(R"([{"mesh":0,"children":[0]}])")).find("tree"), std::string::npos);
  EXPECT_NE(refusal(scene(R"([{"children":[1,1]},{"mesh":0}])")).find("tree"), std::string::npos);
  EXPECT_NE(refusal(scene(R"([{"children":[5]}])")), "");
  EXPECT_NE(refusal(scene(R"([{"mesh":9}])")), "");
}

TEST(HostileGlb, DeepNestingIsRefusedBeforeItIsParsed) {
  const std::string deep = R"(,"extras":)" + std::string(200'000, '[') + std::string(200'000, ']');
  EXPECT_NE(refusal(scene(R"([{"mesh":0}])", R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"})",
                          R"({"buffer":0,"byteLength":36})", R"({"attributes":{"POSITION":0}})", deep))
                .find("nested deeper"),
            std::string::npos);
}

TEST(HostileGlb, ASmallFileMayNotAskForAHugeMesh) {
  std::string nodes = R"([{"children":[)";
  for (int i = 1; i <= 3000; ++i) nodes += std::to_string(i) + (i < 3000 ? "," : "]}");
  for (int i = 1; i <= 3000; ++i) nodes += R"(,{"mesh":0})";
  std::string primitives = R"({"attributes":{"POSITION":0}})";
  for (int i = 0; i < 200; ++i) primitives += R"(,{"attributes":{"POSITION":0}})";
  EXPECT_NE(refusal(scene(nodes + "]", R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"})",
                          R"({"buffer":0,"byteLength":36})", primitives))
                .find("believed"),
            std::string::npos);
}

TEST(HostileGlb, OtherFilesAreNotOpened) {
  std::string json = scene();
  json.replace(json.find(R"({"byteLength":64})"), 17, R"({"byteLength":9,"uri":"/etc/hostname"})");
  EXPECT_NE(refusal(json), "");
}

TEST(HostileGlb, RequiredExtensionsAreNamed) {
  EXPECT_NE(
      refusal(
          scene(
              R"([{"mesh":0}])", R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"})",
              R"({"buffer":0,"byteLength":36})", R"({"attributes":{"POSITION":0}})",
              R"(,"extensionsUsed":["KHR_draco_mesh_compression"],"extensionsRequired":["KHR_draco_mesh_compression"])"))
          .find("KHR_draco_mesh_compression"),
      std::string::npos);
}

TEST(ReadGlb, AppliesNodeTransformsAndFlipsMirroredTriangles) {
  std::string binary(64, '\0');
  const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  std::memcpy(binary.data(), corners, sizeof(corners));
  const std::string json = scene(R"([{"translation":[0,0,5],"children":[1]},{"mesh":0,"scale":[-2,1,1]}])");
  const auto mesh = parse_mesh(glb_of(json, binary), MeshFormat::kGlb, {});
  ASSERT_TRUE(mesh) << mesh.error().text();
  EXPECT_EQ(mesh->positions_m[1], Eigen::Vector3f(-2, 0, 5));
  EXPECT_EQ(mesh->triangles[0], (Triangle{0, 2, 1}));
}

}  // namespace
}  // namespace scanknit
