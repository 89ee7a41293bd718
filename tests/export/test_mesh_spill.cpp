// Meshes written part by part.
#include <gtest/gtest.h>

#include <limits>

#include "export/mesh_spill.h"
#include "export/read_mesh.h"
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
