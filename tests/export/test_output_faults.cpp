// Disks and meshes that cannot be written.
#include <gtest/gtest.h>

#include <limits>

#include "export/mesh/write_mesh.h"
#include "export/picture/preview.h"
#include "tests/core/temporary_folder.h"
#include "tests/export/export_samples.h"
#include "tests/export/tiny_disk.h"

namespace scanknit {
namespace {

using test::read_text;
using test::TemporaryFolder;
using test::TinyDisk;
using test::write_text;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

class EveryFormat : public ::testing::TestWithParam<const char*> {
 protected:
  /// The error of writing `mesh`, which must leave no trace.
  [[nodiscard]] static Error refusal(const Mesh& mesh) {
    const TemporaryFolder folder;
    const auto written = write_mesh(mesh, folder / GetParam(), {}, UpAxis::kY);
    EXPECT_FALSE(written);
    EXPECT_EQ(folder.entries(), 0u);
    return written ? Error{} : written.error();
  }
};
INSTANTIATE_TEST_SUITE_P(Fault, EveryFormat, ::testing::Values("m.glb", "m.ply", "m.obj", "m.stl"));

TEST_P(EveryFormat, FullDiskKeepsTheOldFileAndLeavesNoTemporary) {
  const TemporaryFolder folder;
  const TinyDisk disk(folder.path());
  if (!disk.is_mounted()) GTEST_SKIP() << "SKIPPED: a tiny file system needs root";
  write_text(folder / GetParam(), "old");
  const auto written = write_mesh(test::marked_sphere(), folder / GetParam(), {}, UpAxis::kY);
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::kOutput);
  EXPECT_EQ(written.error().where, (folder / GetParam()).string());
  EXPECT_NE(written.error().message.find("No space left"), std::string::npos);
  EXPECT_EQ(read_text(folder / GetParam()), "old");
  EXPECT_EQ(folder.entries(), 1u);
}

TEST_P(EveryFormat, DestinationThatIsAFolderIsRefused) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / GetParam());
  const auto written = write_mesh(test::cube(), folder / GetParam(), {}, UpAxis::kY);
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::kOutput);
}

TEST_P(EveryFormat, PathBelowAFileIsRefused) {
  const TemporaryFolder folder;
  write_text(folder / "plain", "x");
  const auto written = write_mesh(test::cube(), folder / "plain" / GetParam(), {}, UpAxis::kY);
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::kOutput);
}

TEST_P(EveryFormat, EmptyMeshIsRefused) {
  EXPECT_EQ(refusal(Mesh{}).code, ErrorCode::kMesh);
  Mesh points;
  points.positions_m.emplace_back(0, 0, 0);
  EXPECT_EQ(refusal(points).code, ErrorCode::kMesh);
}

TEST_P(EveryFormat, NaNAndInfinityAreRefused) {
  Mesh mesh = test::small_mesh();
  mesh.positions_m[2].z() = kNaN;
  EXPECT_EQ(refusal(mesh).message, "the position of vertex 2 is not finite");
  mesh.positions_m[2].z() = -std::numeric_limits<float>::infinity();
  EXPECT_EQ(refusal(mesh).code, ErrorCode::kMesh);
}

TEST_P(EveryFormat, NaNInANormalIsRefused) {
  Mesh mesh = test::small_mesh();
  mesh.normals[1].x() = kNaN;
  EXPECT_EQ(refusal(mesh).code, ErrorCode::kMesh);
}

TEST_P(EveryFormat, IndexOutOfRangeIsRefused) {
  Mesh mesh = test::small_mesh();
  mesh.triangles[3][1] = 4;
  EXPECT_EQ(refusal(mesh).code, ErrorCode::kMesh);
}

TEST_P(EveryFormat, ColoursOfAnotherLengthAreRefused) {
  Mesh mesh = test::small_mesh();
  mesh.colours.pop_back();
  EXPECT_EQ(refusal(mesh).code, ErrorCode::kMesh);
}

TEST(StlFault, PositionThatOverflowsInMillimetresIsRefused) {
  const TemporaryFolder folder;
  Mesh mesh = test::tetrahedron();
  mesh.positions_m[1].x() = 1e38f;
  const auto written = write_mesh(mesh, folder / "m.stl", {}, UpAxis::kY);
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::kMesh);
}

TEST(WriteMesh, UnknownExtensionNamesTheKnown) {
  const TemporaryFolder folder;
  const auto written = write_mesh(test::cube(), folder / "m.fbx", {}, UpAxis::kY);
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::kOutput);
  EXPECT_EQ(written.error().message, "unknown mesh extension '.fbx'; known are .glb .ply .obj .stl .3mf .tiles");
}

TEST(WritePng, FullDiskIsAnError) {
  const TemporaryFolder folder;
  const TinyDisk disk(folder.path());
  if (!disk.is_mounted()) GTEST_SKIP() << "SKIPPED: a tiny file system needs root";
  ColourImage noise(320, 240);
  std::uint32_t state = 1;
  for (Rgb8& pixel : noise.pixels()) {  // Knuth's linear congruential generator: does not compress
    state = state * 1664525u + 1013904223u;
    pixel = {static_cast<std::uint8_t>(state >> 24), static_cast<std::uint8_t>(state >> 16), 0};
  }
  const auto written = write_png(noise, folder / "p.png");
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::kOutput);
  EXPECT_EQ(folder.entries(), 0u);
}

TEST(WritePng, PictureWithoutPixelsIsRefused) {
  const TemporaryFolder folder;
  EXPECT_FALSE(write_png(ColourImage{}, folder / "p.png"));
}

}  // namespace
}  // namespace scanknit
