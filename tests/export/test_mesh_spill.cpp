// Meshes written part by part.
#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "export/mesh/read_mesh.h"
#include "export/spill/mesh_spill.h"
#include "tests/core/temporary_folder.h"
#include "tests/export/export_samples.h"

namespace scanknit {
namespace {

using test::read_text;
using test::TemporaryFolder;

/// A sphere of more vertices than are read back at a time.
Mesh large_sphere(bool has_normals) {
  Mesh mesh = test::sphere(160, 320);
  if (!has_normals) mesh.normals.clear();
  return mesh;
}

/// Hands `mesh` over in parts; each part's triangles come before the vertices that the last of them name.
void add_in_parts(const Mesh& mesh, std::size_t parts, MeshSpill& spill) {
  for (std::size_t part = 0; part < parts; ++part) {
    const auto slice = [&](const auto& from, auto& to) {
      const auto at = [&](std::size_t p) {
        return from.begin() + static_cast<std::ptrdiff_t>(from.size() * p / parts);
      };
      to.assign(at(part), at(part + 1));
    };
    Mesh piece;
    slice(mesh.positions_m, piece.positions_m);
    slice(mesh.normals, piece.normals);
    slice(mesh.triangles, piece.triangles);
    ASSERT_TRUE(spill.add(piece));
  }
}

class Spilled : public ::testing::TestWithParam<std::tuple<const char*, bool>> {};
INSTANTIATE_TEST_SUITE_P(Format, Spilled, ::testing::Combine(::testing::Values("m.ply", "m.stl"), ::testing::Bool()));

TEST_P(Spilled, IsTheSameBytesAsTheWholeMesh) {
  const auto [name, has_normals] = GetParam();
  const TemporaryFolder folder;
  const Mesh mesh = large_sphere(has_normals);
  for (const std::optional<double> file_unit_m : {std::optional<double>{}, std::optional<double>{1e-3}}) {
    ASSERT_TRUE(write_mesh(mesh, folder / name, {}, UpAxis::kY, file_unit_m));
    const std::string whole = read_text(folder / name);
    for (const std::size_t parts : {1u, 7u, 40u}) {
      auto spill = MeshSpill::create(folder.path());
      ASSERT_TRUE(spill);
      add_in_parts(mesh, parts, *spill);
      EXPECT_EQ(spill->vertices(), mesh.positions_m.size());
      EXPECT_EQ(spill->triangles(), mesh.triangles.size());
      const auto written = spill->write(folder / name, {}, UpAxis::kY, file_unit_m);
      ASSERT_TRUE(written) << written.error().text();
      EXPECT_TRUE(read_text(folder / name) == whole) << parts;
      EXPECT_EQ(written->bytes, whole.size());
    }
  }
}

TEST(MeshSpill, LeavesNothingBehind) {
  const TemporaryFolder folder;
  {
    auto spill = MeshSpill::create(folder.path());
    ASSERT_TRUE(spill);
    add_in_parts(test::sphere(), 3, *spill);
    EXPECT_EQ(folder.entries(), 0u);
  }
  EXPECT_EQ(folder.entries(), 0u);
}

TEST(MeshSpill, KnowsItsBounds) {
  const TemporaryFolder folder;
  auto spill = MeshSpill::create(folder.path());
  ASSERT_TRUE(spill);
  add_in_parts(test::cube(), 2, *spill);
  EXPECT_EQ(spill->bounds().min(), Eigen::Vector3f(-1, -1, -1));
  EXPECT_EQ(spill->bounds().max(), Eigen::Vector3f(1, 1, 1));
}

TEST(MeshSpill, RefusesWhatCannotBeWrittenInParts) {
  const TemporaryFolder folder;
  auto spill = MeshSpill::create(folder.path());
  ASSERT_TRUE(spill);
  add_in_parts(test::cube(), 2, *spill);
  for (const char* name : {"m.glb", "m.obj"}) {
    const auto written = spill->write(folder / name, {}, UpAxis::kY);
    ASSERT_FALSE(written);
    EXPECT_EQ(written.error().code, ErrorCode::kBudget);
  }
  EXPECT_EQ(folder.entries(), 0u);
}

TEST(MeshSpill, RefusesAnEmptyMeshNaNAndIndicesOutOfRange) {
  const TemporaryFolder folder;
  auto empty = MeshSpill::create(folder.path());
  ASSERT_TRUE(empty);
  EXPECT_EQ(empty->write(folder / "m.ply", {}, UpAxis::kY).error().code, ErrorCode::kMesh);

  Mesh nan = test::cube();
  nan.positions_m[3].y() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(empty->add(nan).error().code, ErrorCode::kMesh);

  Mesh beyond = test::cube();
  beyond.triangles[2][1] = 8;
  auto spill = MeshSpill::create(folder.path());
  ASSERT_TRUE(spill);
  ASSERT_TRUE(spill->add(beyond));
  for (const char* name : {"m.ply", "m.stl"}) {
    EXPECT_EQ(spill->write(folder / name, {}, UpAxis::kY).error().code, ErrorCode::kMesh);
  }
  EXPECT_EQ(folder.entries(), 0u);
}

Mesh coarse(const Mesh& mesh, std::size_t parts, std::size_t most_vertices) {
  const TemporaryFolder folder;
  auto spill = MeshSpill::create(folder.path());
  EXPECT_TRUE(spill);
  add_in_parts(mesh, parts, *spill);
  auto joined = spill->coarse(most_vertices);
  EXPECT_TRUE(joined);
  return joined ? *joined : Mesh{};
}

TEST(CoarseMesh, HasFewVerticesNearTheSurfaceFacingOutwards) {
  constexpr std::size_t kMost = 3000;
  constexpr float kCubeSide = 2.0f / 16;  // 3,000 cubes of this size meet the sphere; twice as fine ones are too many
  const Mesh mesh = coarse(large_sphere(true), 7, kMost);
  EXPECT_LE(mesh.positions_m.size(), kMost);
  EXPECT_GT(mesh.positions_m.size(), kMost / 8);
  for (std::size_t i = 0; i < mesh.positions_m.size(); ++i) {
    EXPECT_NEAR(mesh.positions_m[i].norm(), 1, kCubeSide * kCubeSide);  // a chord's height
    EXPECT_GT(mesh.normals[i].dot(mesh.positions_m[i].normalized()), 0.99f);
  }
  const MeshCheck check = check_mesh(mesh);
  EXPECT_TRUE(check.is_well_formed);
  EXPECT_EQ(check.duplicate_triangles, 0u);
  EXPECT_EQ(check.boundary_edges, 0u);
  EXPECT_NEAR(signed_volume_m3(mesh), 4.0 / 3 * std::numbers::pi, 0.1);
}

TEST(CoarseMesh, IsTheMeshItselfWhereThatHasOneVertexACube) {
  const Mesh cube = test::cube(), mesh = coarse(cube, 2, 1000);
  EXPECT_EQ(mesh.positions_m, cube.positions_m);
  EXPECT_EQ(mesh.triangles.size(), cube.triangles.size());
  EXPECT_EQ(check_mesh(mesh).euler, 2);
  EXPECT_GT(signed_volume_m3(mesh), 0);
}

TEST(CoarseMesh, IsTheSameHoweverTheMeshCame) {
  const Mesh one = coarse(large_sphere(true), 1, 5000), many = coarse(large_sphere(true), 40, 5000);
  EXPECT_EQ(one.positions_m, many.positions_m);
  EXPECT_EQ(one.normals, many.normals);
  EXPECT_EQ(one.triangles, many.triangles);
}

TEST(CoarseMesh, OfNothingOrOfIndicesOutOfRangeIsRefused) {
  const TemporaryFolder folder;
  auto spill = MeshSpill::create(folder.path());
  ASSERT_TRUE(spill);
  EXPECT_EQ(spill->coarse(1000).error().code, ErrorCode::kMesh);
  Mesh beyond = test::cube();
  beyond.triangles[2][1] = 8;
  ASSERT_TRUE(spill->add(beyond));
  EXPECT_EQ(spill->coarse(1000).error().code, ErrorCode::kMesh);
}

TEST(MeshSpill, AFolderThatCannotBeWrittenIsAnError) {
  const auto spill = MeshSpill::create("/proc/no/such/folder");
  ASSERT_FALSE(spill);
  EXPECT_EQ(spill.error().code, ErrorCode::kOutput);
}

TEST(FileUnit, PlyObjAndStlKeepItAndGlbIsMetres) {
  const TemporaryFolder folder;
  constexpr double kMillimetre = 1e-3;
  for (const char* name : {"m.ply", "m.obj", "m.stl", "m.glb"}) {
    ASSERT_TRUE(write_mesh(test::cube(), folder / name, {}, UpAxis::kZ, kMillimetre));
    const auto read = read_mesh(folder / name);
    ASSERT_TRUE(read);
    const float side = check_mesh(*read).max_m.x();
    EXPECT_FLOAT_EQ(side, std::string(name) == "m.glb" ? 0.001f : 1.0f) << name;
  }
}

TEST(FileUnit, IsSaidInTheFile) {
  const TemporaryFolder folder;
  const auto written = write_mesh(test::cube(), folder / "m.ply", {}, UpAxis::kZ, 1e-3);
  ASSERT_TRUE(written);
  EXPECT_EQ(written->convention, "millimetres, the volume's own axes");
  EXPECT_NE(read_text(folder / "m.ply").find("comment positions in millimetres\n"), std::string::npos);
}

}  // namespace
}  // namespace scanknit
