// Files that other programs write.
#include <gtest/gtest.h>

#include <cmath>

#include "export/mesh/mesh_readers.h"
#include "export/mesh/read_mesh.h"
#include "tests/core/temporary_folder.h"
#include "tests/export/export_samples.h"
#include "tests/support/places.h"

namespace scanknit {
namespace {

Mesh parsed(std::string_view text, MeshFormat format) {
  auto mesh = parse_mesh(text, format, {});
  EXPECT_TRUE(mesh) << (mesh ? "" : mesh.error().text());
  return mesh ? *mesh : Mesh{};
}

std::string refusal(std::string_view text, MeshFormat format, const Limits& limits = {}) {
  const auto mesh = parse_mesh(text, format, limits);
  EXPECT_FALSE(mesh);
  if (mesh) return {};
  EXPECT_EQ(mesh.error().code, ErrorCode::kInput);
  return mesh.error().message;
}

constexpr std::string_view kAsciiPly =
    "ply\r\nformat ascii 1.0\r\ncomment hello\r\nelement vertex 4\r\nproperty double x\r\nproperty float y\r\n"
    "property float z\r\nproperty float confidence\r\nproperty uchar red\r\nproperty uchar green\r\nproperty uchar "
    "blue\r\n"
    "element face 1\r\nproperty list uchar int vertex_index\r\nproperty uchar flags\r\n"
    "element edge 1\r\nproperty int a\r\nproperty int b\r\nend_header\r\n"
    "0 0 0 1 255 0 0\r\n1 0 0 .5 0 255 0\r\n1 1 0 .5 0 0 255\r\n0 1 0 .5 9 9 9\r\n4 0 1 2 3 7\r\n0 1\r\n";

TEST(ReadPly, FansPolygonsAndSkipsWhatItDoesNotKnow) {
  const Mesh mesh = parsed(kAsciiPly, MeshFormat::kPly);
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_EQ(mesh.positions_m[2], Eigen::Vector3f(1, 1, 0));
  EXPECT_EQ(mesh.colours[1], (Rgb8{0, 255, 0}));
  EXPECT_TRUE(mesh.normals.empty());
}

TEST(ReadPly, NotesTheUncertaintyOfVertices) {
  MeshNotes notes;
  ASSERT_TRUE(
      parse_mesh("ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float "
                 "z\nproperty float uncertainty\nend_header\n1 2 3 0.00025\n4 5 6 nan\n",
                 MeshFormat::kPly, {}, &notes));
  ASSERT_EQ(notes.uncertainty_m.size(), 2u);
  EXPECT_EQ(notes.uncertainty_m[0], 0.00025f);
  EXPECT_TRUE(std::isnan(notes.uncertainty_m[1]));
  notes = {};
  ASSERT_TRUE(parse_mesh(kAsciiPly, MeshFormat::kPly, {}, &notes));
  EXPECT_TRUE(notes.uncertainty_m.empty());
}

TEST(ReadPly, ReadsBigEndian) {
  std::string text =
      "ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty short x\nproperty short y\nproperty short z\n"
      "element face 1\nproperty list uchar ushort vertex_indices\nend_header\n";
  for (const int value : {0, 0, 0, 258, 0, 0, 0, 1, 0}) {
    text += {static_cast<char>(value / 256), static_cast<char>(value % 256)};
  }
  text += std::string("\3\0\0\0\1\0\2", 7);
  const Mesh mesh = parsed(text, MeshFormat::kPly);
  EXPECT_EQ(mesh.positions_m[1], Eigen::Vector3f(258, 0, 0));
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}}));
}

TEST(ReadPly, PointsWithoutFacesAreAMeshWithoutTriangles) {
  const Mesh mesh = parsed(
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
      "end_header\n1 2 3\n",
      MeshFormat::kPly);
  EXPECT_EQ(mesh.positions_m.size(), 1u);
  EXPECT_TRUE(mesh.empty());
}

TEST(ReadPly, BelievesNoCountThatTheFileCannotHold) {
  const std::string text =
      "ply\nformat binary_little_endian 1.0\nelement vertex 1000000000\nproperty float x\n"
      "property float y\nproperty float z\nend_header\n";
  EXPECT_NE(refusal(text, MeshFormat::kPly).find("truncated"), std::string::npos);
}

TEST(ReadPly, BelievesNoListThatTheFileCannotHold) {
  std::string text =
      "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty uchar x\nproperty uchar y\n"
      "property uchar z\nelement face 1\nproperty list uint int vertex_indices\nend_header\n";
  text += std::string("\0\0\0\xFF\xFF\xFF\x7F", 7);
  EXPECT_NE(refusal(text, MeshFormat::kPly).find("face 0 of 1"), std::string::npos);
}

TEST(ReadPly, CountsOfElementsWithoutPropertiesCostNothing) {
  const Mesh mesh = parsed(
      "ply\nformat ascii 1.0\nelement nothing 9000000000000000000\nelement vertex 1\nproperty float x\n"
      "property float y\nproperty float z\nend_header\n1 2 3",
      MeshFormat::kPly);
  EXPECT_EQ(mesh.positions_m.size(), 1u);
}

TEST(ReadPly, KeepsToTheLimits) {
  Limits limits;
  limits.max_mesh_vertices = 3;
  EXPECT_NE(refusal(kAsciiPly, MeshFormat::kPly, limits).find("limit of 3"), std::string::npos);
  limits.max_mesh_vertices = 4;
  limits.max_mesh_triangles = 1;
  EXPECT_NE(refusal(kAsciiPly, MeshFormat::kPly, limits).find("limit of 1"), std::string::npos);
}

TEST(ReadPly, RefusesIndicesOutOfRange) {
  std::string text(kAsciiPly);
  text.replace(text.find("4 0 1 2 3"), 9, "4 0 1 2 4");
  EXPECT_NE(refusal(text, MeshFormat::kPly).find("vertex 4 of the 4"), std::string::npos);
  text.replace(text.find("4 0 1 2 4"), 9, "3 0 1 -2 ");
  refusal(text, MeshFormat::kPly);
}

TEST(ReadPly, RefusesPositionsThatAreNotFinite) {
  std::string text(kAsciiPly);
  text.replace(text.find("1 1 0 .5"), 1, "nan");
  EXPECT_NE(refusal(text, MeshFormat::kPly).find("not finite"), std::string::npos);
}

TEST(ReadPly, SaysWhatIsWrongWithAHeader) {
  EXPECT_NE(refusal("", MeshFormat::kPly).find("not a PLY"), std::string::npos);
  EXPECT_NE(refusal("ply\nformat ascii 1.0\n", MeshFormat::kPly).find("end_header"), std::string::npos);
  EXPECT_NE(refusal("ply\nend_header\n", MeshFormat::kPly).find("no format"), std::string::npos);
  EXPECT_NE(refusal("ply\nformat ascii 1.0\nelement vertex -1\nend_header\n", MeshFormat::kPly).find("element"),
            std::string::npos);
  EXPECT_NE(refusal("ply\nformat ascii 1.0\nproperty float x\nend_header\n", MeshFormat::kPly).find("property"),
            std::string::npos);
  EXPECT_NE(refusal("ply\nformat ascii 1.0\nend_header\n", MeshFormat::kPly).find("without vertices"),
            std::string::npos);
}

TEST(ReadObj, FansPolygonsWithEveryKindOfCorner) {
  const Mesh mesh = parsed(
      "o thing\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nusemtl m\n"
      "f 1 2/1 3//1 4/1/1\nf -4 -3 -2\n",
      MeshFormat::kObj);
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 1, 2}}));
  EXPECT_EQ(mesh.normals[2], Eigen::Vector3f(0, 0, 1));
  EXPECT_EQ(mesh.normals[0], Eigen::Vector3f(0, 0, 0));  // no corner gave it one
}

TEST(ReadObj, ReadsColours) {
  const Mesh mesh = parsed("v 0 0 0 1 0.5 0\nv 1 0 0 2 -1 0\nv 0 1 0 0 0 0\nf 1 2 3\n", MeshFormat::kObj);
  EXPECT_EQ(mesh.colours[0], (Rgb8{255, 128, 0}));
  EXPECT_EQ(mesh.colours[1], (Rgb8{255, 0, 0}));  // clamped
}

TEST(ReadObj, ColoursOfSomeVerticesOnlyAreDropped) {
  EXPECT_TRUE(parsed("v 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", MeshFormat::kObj).colours.empty());
}

TEST(ReadObj, NamesTheLineThatIsWrong) {
  EXPECT_EQ(refusal("v 0 0 0\nv 1 0\n", MeshFormat::kObj), "line 2: a vertex of fewer than three numbers");
  EXPECT_EQ(refusal("v 0 0 0\nf 1 1 2\n", MeshFormat::kObj), "line 2: a face corner '2' that does not exist");
  EXPECT_EQ(refusal("v 0 0 0\nf 1 0 1\n", MeshFormat::kObj), "line 2: a face corner '0' that does not exist");
  EXPECT_EQ(refusal("v 0 0 0\nf 1 -2 1\n", MeshFormat::kObj), "line 2: a face corner '-2' that does not exist");
  EXPECT_EQ(refusal("v 0 0 0\nf 1//1 1 1\n", MeshFormat::kObj), "line 2: a face corner '1//1' that does not exist");
}

TEST(ReadObj, ReadsTheReferenceMesh) {
  const std::filesystem::path data = test::data_folder();
  if (!std::filesystem::exists(data / "meshes/spot.obj")) GTEST_SKIP() << "SKIPPED: no meshes/spot.obj in " << data;
  const auto mesh = read_mesh(data / "meshes/spot.obj");
  ASSERT_TRUE(mesh) << mesh.error().text();
  const MeshCheck check = check_mesh(*mesh);
  EXPECT_TRUE(check.is_closed());
  EXPECT_TRUE(check.is_manifold());
  EXPECT_EQ(check.euler, 2);
}

constexpr std::string_view kAsciiStl =
    "solid s\nfacet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  vertex 0 1 0\n endloop\nendfacet\n\n"
    "facet normal 0 0 1\n outer loop\n  vertex 1 0 0\n  vertex 1 1e0 0\n  vertex 0 +1 0\n endloop\nendfacet\nendsolid "
    "s\n";

TEST(ReadStl, WeldsBitEqualCornersOfAscii) {
  const Mesh mesh = parsed(kAsciiStl, MeshFormat::kStl);
  EXPECT_EQ(mesh.positions_m.size(), 4u);
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {1, 3, 2}}));
}

TEST(ReadStl, WeldsMinusZeroToZero) {
  const Mesh mesh =
      parsed("solid\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nvertex -0 1 0\nvertex 1 -0 0\nvertex 1 1 0\nendsolid\n",
             MeshFormat::kStl);
  EXPECT_EQ(mesh.positions_m.size(), 4u);
}

TEST(ReadStl, TakesABinaryFileThatBeginsWithSolid) {
  const test::TemporaryFolder folder;
  std::string bytes(84 + 50, '\0');
  bytes.replace(0, 5, "solid");
  bytes[80] = 1;
  EXPECT_EQ(parsed(bytes, MeshFormat::kStl).triangles.size(), 1u);
}

TEST(ReadStl, RefusesATextThatEndsInsideASolid) {
  const std::string_view cut = kAsciiStl.substr(0, kAsciiStl.find("endsolid"));
  EXPECT_NE(refusal(cut, MeshFormat::kStl).find("truncated"), std::string::npos);
}

TEST(ReadMesh, NamesTheFile) {
  const test::TemporaryFolder folder;
  test::write_text(folder / "m.ply", "nonsense");
  const auto mesh = read_mesh(folder / "m.ply");
  ASSERT_FALSE(mesh);
  EXPECT_EQ(mesh.error().where, (folder / "m.ply").string());
}

TEST(ReadMesh, UnknownExtensionNamesTheKnown) {
  EXPECT_EQ(read_mesh("m.fbx").error().message,
            "unknown mesh extension '.fbx'; known are .glb .ply .obj .stl .step .stp");
}

TEST(ReadMesh, RefusesAFileBeyondTheLimit) {
  const test::TemporaryFolder folder;
  test::write_text(folder / "m.obj", "v 0 0 0\n");
  Limits limits;
  limits.max_mesh_bytes = 7;
  EXPECT_FALSE(read_mesh(folder / "m.obj", limits));
}

}  // namespace
}  // namespace scanknit
