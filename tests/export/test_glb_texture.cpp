// Textured GLB files, read: each vertex has the colour of its texel.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "core/files/crc32.h"
#include "core/picture/jpeg_codec.h"
#include "core/picture/png_codec.h"
#include "export/glb/glb_container.h"
#include "export/mesh/mesh_extension.h"
#include "export/mesh/mesh_readers.h"
#include "export/mesh/write_mesh.h"
#include "export/texture/mesh_texture.h"
#include "export/texture/srgb.h"
#include "tests/core/temporary_folder.h"
#include "tests/export/every_packing.h"
#include "tests/export/export_samples.h"
#include "tests/export/texture_samples.h"

namespace scanknit {
namespace {

using test::TemporaryFolder;
using Json = nlohmann::json;
using Bytes = std::vector<std::uint8_t>;

struct Textured {
  Mesh mesh;  ///< with the colours that a reader must find; they are not written
  MeshTexture texture;
};

Rgb8 colour_of(std::size_t vertex) {
  return {static_cast<std::uint8_t>(37 * vertex % 251), static_cast<std::uint8_t>(91 * vertex % 241),
          static_cast<std::uint8_t>(vertex / 3 % 256)};
}

Textured squares(int side, bool is_png) {
  Textured made{test::sphere(), {}};
  for (std::size_t v = 0; v < made.mesh.positions_m.size(); ++v) made.mesh.colours.push_back(colour_of(v));
  made.texture = test::own_texels(made.mesh, side, is_png).texture;
  return made;
}

std::string glb_of(const Textured& made, const ExportConfig& config) {
  const TemporaryFolder folder;
  Mesh bare = made.mesh;
  bare.colours.clear();
  const auto written = write_mesh(bare, folder / "m.glb", config, UpAxis::kY, std::nullopt, &made.texture);
  EXPECT_TRUE(written) << (written ? "" : written.error().text());
  return test::read_text(folder / "m.glb");
}

/// The largest difference of a channel from that of the vertex that lies nearest; 256 without colours.
int worst_difference(const Mesh& read, const Mesh& expected) {
  if (read.colours.size() != expected.positions_m.size()) return 256;
  int worst = 0;
  for (std::size_t i = 0; i < read.colours.size(); ++i) {
    const auto distance = [&](const Eigen::Vector3f& p) { return (p - read.positions_m[i]).squaredNorm(); };
    const auto nearest = std::min_element(expected.positions_m.begin(), expected.positions_m.end(),
                                          [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
    const Rgb8 a = read.colours[i],
               b = expected.colours[static_cast<std::size_t>(nearest - expected.positions_m.begin())];
    worst = std::max({worst, std::abs(a.r - b.r), std::abs(a.g - b.g), std::abs(a.b - b.b)});
  }
  return worst;
}

class ReadTexturedGlb : public test::EveryPacking {};
INSTANTIATE_TEST_SUITE_P(EveryPacking, ReadTexturedGlb, ::testing::Range(0, 4));

TEST_P(ReadTexturedGlb, GivesEachVertexTheExactColourOfItsTexel) {
  const Textured made = squares(1, true);
  MeshNotes notes;
  const auto read = parse_mesh(glb_of(made, config()), MeshFormat::kGlb, {}, &notes);
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(worst_difference(*read, made.mesh), 0);
  EXPECT_TRUE(notes.warnings.empty());
}

TEST_P(ReadTexturedGlb, ReadsJpeg) {
  constexpr int kCodingError = 12;  // of one colour in each block of 16 texels, at quality 92
  const Textured made = squares(16, false);
  const auto read = parse_mesh(glb_of(made, config()), MeshFormat::kGlb, {});
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_LE(worst_difference(*read, made.mesh), kCodingError);
}

constexpr Rgb8 kRed{200, 10, 20}, kGreen{30, 190, 40}, kBlue{50, 60, 180}, kGrey{90, 90, 90};

/// Two by two texels.
Bytes small_picture(bool is_png = true) {
  ColourImage image(2, 2);
  image.at(0, 0) = kRed;
  image.at(1, 0) = kGreen;
  image.at(0, 1) = kBlue;
  image.at(1, 1) = kGrey;
  return *(is_png ? encode_png(image, PngEffort::kFast) : encode_jpeg(image, 92));
}

/// One triangle whose corners lie on red, green and blue; the tests change its parts.
struct Scene {
  std::vector<Eigen::Vector2f> coordinates = {{0.25f, 0.25f}, {0.75f, 0.25f}, {0.25f, 0.75f}};
  Bytes picture = small_picture();
  Json json = Json::parse(R"({
    "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
                  {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 24}],
    "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
    "textures": [{"source": 0, "sampler": 0}], "samplers": [{"wrapS": 33071, "wrapT": 33071}],
    "images": [{"bufferView": 2, "mimeType": "image/png"}]})");

  [[nodiscard]] std::string glb() const {
    const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    std::string binary(60, '\0');
    std::memcpy(binary.data(), corners, sizeof(corners));
    for (std::size_t i = 0; i < 3; ++i) std::memcpy(binary.data() + 36 + 8 * i, coordinates[i].data(), 8);
    binary.append(picture.begin(), picture.end());
    Json whole = json;
    whole["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", 60}, {"byteLength", picture.size()}});
    whole["buffers"] = Json::array({{{"byteLength", binary.size()}}});
    return glb_container(whole.dump(), binary);
  }
  Json& primitive() { return json["meshes"][0]["primitives"][0]; }
  Json& material() { return json["materials"][0]["pbrMetallicRoughness"]; }
};

std::vector<Rgb8> colours_of(const Scene& scene) {
  const auto read = parse_mesh(scene.glb(), MeshFormat::kGlb, {});
  EXPECT_TRUE(read) << (read ? "" : read.error().text());
  return read ? read->colours : std::vector<Rgb8>();
}

/// What is said of a texture that is left out; the triangle must be there, grey.
std::string warning_of(const Scene& scene, const Limits& limits = {}) {
  MeshNotes notes;
  const auto read = parse_mesh(scene.glb(), MeshFormat::kGlb, limits, &notes);
  EXPECT_TRUE(read) << (read ? "" : read.error().text());
  EXPECT_TRUE(read && read->colours.empty() && read->triangles.size() == 1);
  EXPECT_EQ(notes.warnings.size(), 1u);
  return notes.warnings.empty() ? "" : notes.warnings.front();
}

std::string refusal_of(const Scene& scene) {
  const auto read = parse_mesh(scene.glb(), MeshFormat::kGlb, {});
  EXPECT_FALSE(read);
  return read ? "" : read.error().message;
}

std::vector<Rgb8> wrapped(int wrap) {
  Scene scene;
  scene.json["samplers"][0] = {{"wrapS", wrap}, {"wrapT", wrap}};
  scene.coordinates = {{1.25f, 0.25f}, {-0.25f, 0.25f}, {0.25f, 2.75f}};
  return colours_of(scene);
}

TEST(GlbTexture, CoordinatesOutsideThePictureWrapAsTheSamplerSays) {
  constexpr int kClamp = 33071, kMirror = 33648, kRepeat = 10497;
  EXPECT_EQ(wrapped(kClamp), (std::vector{kGreen, kRed, kBlue}));
  EXPECT_EQ(wrapped(kRepeat), (std::vector{kRed, kGreen, kBlue}));
  EXPECT_EQ(wrapped(kMirror), (std::vector{kGreen, kRed, kBlue}));
}

TEST(GlbTexture, IsMultipliedByTheMaterialsFactorInLinearLight) {
  Scene scene;
  scene.material()["baseColorFactor"] = {0.5, 1, 0, 1};
  const auto half = [](std::uint8_t c) { return srgb_from_linear(0.5 * linear_from_srgb(c)); };
  EXPECT_EQ(colours_of(scene), (std::vector{Rgb8{half(200), 10, 0}, Rgb8{half(30), 190, 0}, Rgb8{half(50), 60, 0}}));
}

TEST(GlbTexture, IsMultipliedByTheVerticesColours) {
  Scene scene;  // the positions' bytes as colours: 0 and 1 of each channel
  scene.primitive()["attributes"]["COLOR_0"] = 0;
  EXPECT_EQ(colours_of(scene), (std::vector{Rgb8{0, 0, 0}, Rgb8{30, 0, 0}, Rgb8{0, 60, 0}}));
}

TEST(GlbTexture, CoordinatesThatAreNoNumbersAreHarmless) {
  Scene scene;
  scene.coordinates = {{std::nanf(""), 0.25f}, {INFINITY, 0.25f}, {0.25f, 3e38f}};
  EXPECT_EQ(colours_of(scene), (std::vector{kRed, kRed, kBlue}));
}

TEST(GlbTexture, NumbersOfWhatIsNotThereAreRefused) {
  const auto refused = [](const char* where, const Json& value) {
    Scene scene;
    scene.json[Json::json_pointer(where)] = value;
    return refusal_of(scene);
  };
  EXPECT_NE(refused("/meshes/0/primitives/0/material", 7).find("material"), std::string::npos);
  EXPECT_NE(refused("/materials/0/pbrMetallicRoughness/baseColorTexture/index", 7).find("texture"), std::string::npos);
  EXPECT_NE(refused("/textures/0/source", 7).find("picture"), std::string::npos);
  EXPECT_NE(refused("/textures/0/sampler", 7).find("sampler"), std::string::npos);
  EXPECT_NE(refused("/meshes/0/primitives/0/attributes/TEXCOORD_0", 7).find("accessor"), std::string::npos);
  EXPECT_NE(refused("/accessors/1/count", 2).find("two a vertex"), std::string::npos);
  EXPECT_NE(refused("/accessors/1/count", 4).find("outside"), std::string::npos);
  EXPECT_NE(refused("/images/0/bufferView", 7), "");
}

TEST(GlbTexture, APictureCutAtAnyByteLeavesTheMeshGreyAndIsTold) {
  for (const bool is_png : {true, false}) {
    Scene scene;
    const Bytes whole = small_picture(is_png);
    for (std::size_t length = 1; length < whole.size(); ++length) {
      scene.picture.assign(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length));
      EXPECT_NE(warning_of(scene), "") << length;
    }
  }
}

/// A PNG of four texels whose header speaks of others.
Bytes png_that_claims(std::uint32_t width, std::uint32_t height) {
  Bytes png = small_picture();
  const auto put = [&](std::size_t at, std::uint32_t value) {
    for (std::size_t i = 0; i < 4; ++i) png[at + i] = static_cast<std::uint8_t>(value >> (24 - 8 * i) & 0xFF);
  };
  put(16, width);  // after the signature, the header's length and its name
  put(20, height);
  put(29, crc32(std::as_bytes(std::span(png)).subspan(12, 17)));
  return png;
}

TEST(GlbTexture, APictureLargerThanIsBelievedIsToldBeforeItIsDecoded) {
  for (const auto& [width, height] : {std::pair{20000u, 20000u}, {0x7FFFFFFFu, 0x7FFFFFFFu}, {0u, 4u}}) {
    Scene scene;
    scene.picture = png_that_claims(width, height);
    EXPECT_NE(warning_of(scene).find("pixels"), std::string::npos);
  }
  Scene scene;
  scene.picture = png_that_claims(3, 2);  // believed, but there is no such picture
  EXPECT_NE(warning_of(scene).find("corrupt"), std::string::npos);
}

/// Two triangles, two pictures that are each small enough.
TEST(GlbTexture, AllPicturesTogetherStayWithinTheLimit) {
  Scene scene;
  scene.json["images"].push_back(scene.json["images"][0]);
  scene.json["textures"].push_back({{"source", 1}});
  scene.json["materials"].push_back(scene.json["materials"][0]);
  scene.json["materials"][1]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 1;
  Json second = scene.primitive();
  second["material"] = 1;
  scene.json["meshes"][0]["primitives"].push_back(second);
  scene.picture = *encode_png(ColourImage(200, 100, kRed), PngEffort::kFast);
  const std::string glb = scene.glb();
  Limits limits;
  limits.max_image_pixels = 30'000;
  ASSERT_LT(16 * glb.size(), 30'000u);
  MeshNotes notes;
  const auto read = parse_mesh(glb, MeshFormat::kGlb, limits, &notes);
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_TRUE(read->colours.empty());
  ASSERT_EQ(notes.warnings.size(), 1u);
  EXPECT_NE(notes.warnings[0].find("pixels"), std::string::npos) << notes.warnings[0];
}

TEST(GlbTexture, PicturesThatAreNotInTheFileAreToldAndNotOpened) {
  Scene scene;
  scene.json["images"][0] = {{"uri", "/etc/hostname"}};
  EXPECT_NE(warning_of(scene).find("not in the file"), std::string::npos);
  scene.json["textures"][0] = {{"extensions", {{"EXT_texture_webp", {{"source", 0}}}}}};
  EXPECT_NE(warning_of(scene).find("PNG and JPEG"), std::string::npos);
}

TEST(GlbTexture, ATransformIsToldSinceColoursWouldBeWrong) {
  Scene scene;
  scene.material()["baseColorTexture"]["extensions"]["KHR_texture_transform"]["scale"] = {2, 2};
  EXPECT_NE(warning_of(scene).find("KHR_texture_transform"), std::string::npos);
}

TEST(GlbTexture, APictureMayStandInTheJsonItself) {
  Scene scene;
  scene.json["images"][0] = {
      {"uri",
       "data:image/"
       "png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGPgUbIAAACkAGeY0OCYAAAAAElFTkSuQmCC"}};
  const auto colours = colours_of(scene);
  ASSERT_EQ(colours.size(), 3u);
  for (const Rgb8& c : colours) EXPECT_EQ(c, (Rgb8{12, 34, 56}));
}

TEST(GlbTexture, AnyByteChangedIsAnsweredAndWellFormed) {
  for (const bool is_png : {true, false}) {
    Scene scene;
    scene.picture = small_picture(is_png);
    const std::string whole = scene.glb();
    for (std::size_t at = 0; at < whole.size(); ++at) {
      for (const int flip : {0x01, 0x80, 0xFF}) {
        std::string changed = whole;
        changed[at] = static_cast<char>(changed[at] ^ flip);
        const auto read = parse_mesh(changed, MeshFormat::kGlb, {});
        if (read) {
          EXPECT_TRUE(check_mesh(*read).is_well_formed) << at;
        }
      }
    }
  }
}

}  // namespace
}  // namespace scanknit
