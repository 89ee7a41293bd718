// Every format is written and read back.
#include <gtest/gtest.h>

#include "export/mesh/mesh_extension.h"
#include "export/mesh/read_mesh.h"
#include "export/mesh/write_mesh.h"
#include "tests/core/temporary_folder.h"
#include "tests/export/export_samples.h"

namespace scanknit {
namespace {

using test::TemporaryFolder;

Mesh round_trip(const Mesh& mesh, const char* name, const ExportConfig& config = {}, UpAxis world_up = UpAxis::kY) {
  const TemporaryFolder folder;
  const auto written = write_mesh(mesh, folder / name, config, world_up);
  EXPECT_TRUE(written) << (written ? "" : written.error().text());
  auto read = read_mesh(folder / name);
  EXPECT_TRUE(read) << (read ? "" : read.error().text());
  return read ? *read : Mesh{};
}

class RoundTrip : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Indexed, RoundTrip, ::testing::Values("m.glb", "m.ply", "m.obj"));

TEST_P(RoundTrip, KeepsPositionsToTheBit) {
  const Mesh mesh = test::small_mesh();
  EXPECT_EQ(round_trip(mesh, GetParam()).positions_m, mesh.positions_m);
}

TEST_P(RoundTrip, KeepsTriangles) {
  const Mesh mesh = test::small_mesh();
  EXPECT_EQ(round_trip(mesh, GetParam()).triangles, mesh.triangles);
}

TEST_P(RoundTrip, KeepsColours) {
  const Mesh mesh = test::small_mesh();
  EXPECT_EQ(round_trip(mesh, GetParam()).colours, mesh.colours);
}

TEST_P(RoundTrip, KeepsNormals) {
  constexpr float kRounding = 1e-6f;  // GLB's are normalised again
  const Mesh mesh = test::small_mesh();
  const Mesh read = round_trip(mesh, GetParam());
  ASSERT_EQ(read.normals.size(), mesh.normals.size());
  for (std::size_t i = 0; i < mesh.normals.size(); ++i) {
    EXPECT_LT((read.normals[i] - mesh.normals[i]).norm(), kRounding);
  }
}

TEST_P(RoundTrip, AddsNoColoursAndNoNormals) {
  const Mesh read = round_trip(test::tetrahedron(), GetParam());
  EXPECT_TRUE(read.colours.empty());
  EXPECT_TRUE(read.normals.empty());
}

TEST_P(RoundTrip, IsTheSameBytesEveryTime) {
  const TemporaryFolder folder;
  const Mesh mesh = test::marked_sphere();
  ASSERT_TRUE(write_mesh(mesh, folder / "a" / GetParam(), {}, UpAxis::kZ));
  ASSERT_TRUE(write_mesh(mesh, folder / "b" / GetParam(), {}, UpAxis::kZ));
  EXPECT_EQ(test::read_text(folder / "a" / GetParam()), test::read_text(folder / "b" / GetParam()));
}

TEST(StlRoundTrip, KeepsTheSurfaceInMillimetres) {
  const Mesh mesh = test::cube();
  const Mesh read = round_trip(mesh, "m.stl", {}, UpAxis::kZ);
  const MeshCheck check = check_mesh(read);
  EXPECT_TRUE(check.is_closed());
  EXPECT_EQ(check.vertices, 8u);  // welded again
  EXPECT_EQ(check.triangles, 12u);
  EXPECT_EQ(check.max_m, Eigen::Vector3f(1000, 1000, 1000));
  EXPECT_GT(signed_volume_m3(read), 0);
}

/// Where the red (+x), green (+y) and blue (+z) markers of the recording's world went.
Eigen::Matrix3f marker_directions(const Mesh& mesh) {
  Eigen::Matrix3f columns = Eigen::Matrix3f::Zero();
  for (std::size_t i = 0; i < mesh.positions_m.size(); ++i) {
    const Rgb8 c = mesh.colours[i];
    if (c.r != c.g) columns.col(c.r > 150 ? 0 : c.g > 150 ? 1 : 2) += mesh.positions_m[i];
  }
  for (int i = 0; i < 3; ++i) columns.col(i).normalize();
  return columns.array().round();
}

TEST(Axes, GlbTurnsACamerasWorldYUp) {
  const Mesh read = round_trip(test::marked_sphere(), "m.glb", {}, UpAxis::kMinusY);
  EXPECT_EQ(marker_directions(read), Eigen::Matrix3f(Eigen::Vector3f(1, -1, -1).asDiagonal()));
}

TEST(Axes, GlbTurnsAZUpWorldYUpWithoutMirroring) {
  const Mesh read = round_trip(test::marked_sphere(), "m.glb", {}, UpAxis::kZ);
  Eigen::Matrix3f expected;  // columns: where x, y and z went
  expected << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  EXPECT_EQ(marker_directions(read), expected);
  EXPECT_GT(signed_volume_m3(read), 0);
}

TEST(Axes, PlyAndObjKeepTheRecordingsWorld) {
  for (const char* name : {"m.ply", "m.obj"}) {
    const Mesh read = round_trip(test::marked_sphere(), name, {}, UpAxis::kMinusY);
    EXPECT_EQ(marker_directions(read), Eigen::Matrix3f::Identity());
  }
}

TEST(Axes, PlyFollowsTheConfiguredUp) {
  ExportConfig config;
  config.up = UpAxis::kZ;
  const Mesh read = round_trip(test::marked_sphere(), "m.ply", config, UpAxis::kMinusY);
  EXPECT_EQ(marker_directions(read).col(1), Eigen::Vector3f(0, 0, -1));
}

TEST(Axes, ConfiguredWorldUpOverridesTheRecordings) {
  ExportConfig config;
  config.world_up = UpAxis::kY;
  const Mesh read = round_trip(test::marked_sphere(), "m.glb", config, UpAxis::kMinusY);
  EXPECT_EQ(marker_directions(read), Eigen::Matrix3f::Identity());
}

TEST(Axes, StlIsZUp) {
  Mesh mesh = test::tetrahedron();
  mesh.positions_m[2] = {0, -5, 0};  // far up in a world whose y points down
  std::swap(mesh.triangles[0][0], mesh.triangles[0][1]);
  const Mesh read = round_trip(mesh, "m.stl", {}, UpAxis::kMinusY);
  EXPECT_EQ(check_mesh(read).max_m.z(), 5000.0f);
}

TEST(WriteMesh, SaysWhichConventionTheFileFollows) {
  const TemporaryFolder folder;
  const Mesh mesh = test::tetrahedron();
  ExportConfig turned;
  turned.up = UpAxis::kZ;
  EXPECT_EQ(write_mesh(mesh, folder / "m.glb", {}, UpAxis::kY)->convention, "metres, Y up");
  EXPECT_EQ(write_mesh(mesh, folder / "m.stl", {}, UpAxis::kY)->convention, "millimetres, Z up");
  EXPECT_EQ(write_mesh(mesh, folder / "m.ply", {}, UpAxis::kY)->convention, "metres, the recording's world");
  EXPECT_EQ(write_mesh(mesh, folder / "m.obj", turned, UpAxis::kY)->convention, "metres, Z up");
}

TEST(WriteMesh, SaysHowManyBytesItWrote) {
  const TemporaryFolder folder;
  const auto written = write_mesh(test::cube(), folder / "m.stl", {}, UpAxis::kY);
  ASSERT_TRUE(written);
  EXPECT_EQ(written->bytes, 84u + 12 * 50);
}

TEST(IsMeshPath, KnowsTheFourInAnyCase) {
  for (const char* path : {"a.glb", "b.PLY", "c.Obj", "x/d.stl"}) EXPECT_TRUE(is_mesh_path(path)) << path;
  for (const char* path : {"a.gltf", "b", "out/", ".glb", "c.vdb"}) EXPECT_FALSE(is_mesh_path(path)) << path;
}

}  // namespace
}  // namespace scanknit
