// 3MF files, unpacked and understood by Python's own zip and XML readers, and by assimp.
#include <gtest/gtest.h>

#include <cstdlib>

#include "export/mesh/mesh_writers.h"
#include "export/mesh/read_mesh.h"
#include "export/mesh/write_mesh.h"
#include "tests/core/temporary_folder.h"
#include "tests/export/export_samples.h"
#include "tests/support/places.h"

namespace scanknit {
namespace {

using test::TemporaryFolder;

bool has_command(const char* name) {
  return std::system((std::string("command -v ") + name + " > /dev/null").c_str()) == 0;
}

void write(const Mesh& mesh, const std::filesystem::path& path, std::optional<double> unit_m = std::nullopt) {
  const auto written = write_mesh(mesh, path, {}, UpAxis::kMinusY, unit_m);
  ASSERT_TRUE(written) << written.error().text();
  EXPECT_EQ(written->convention, "millimetres, Z up");
}

/// What read_3mf.py says of it.
std::string told(const std::filesystem::path& path) {
  const std::string command = "python3 " + test::kSourceDir + "/tests/export/read_3mf.py '" + path.string() + "' > '" +
                              path.string() + ".txt' 2>&1";
  EXPECT_EQ(std::system(command.c_str()), 0) << test::read_text(path.string() + ".txt");
  return test::read_text(path.string() + ".txt");
}

TEST(ThreeMf, PythonReadsCountsSizeAxesAndColours) {
  if (!has_command("python3")) GTEST_SKIP() << "SKIPPED: python3 is not installed";
  const TemporaryFolder folder;
  write(test::marked_sphere(), folder / "m.3mf");
  const std::string mesh = told(folder / "m.3mf");
  const Mesh sphere = test::marked_sphere();
  EXPECT_NE(mesh.find("vertices " + std::to_string(sphere.positions_m.size()) + "\n"), std::string::npos) << mesh;
  EXPECT_NE(mesh.find("triangles " + std::to_string(sphere.triangles.size()) + "\n"), std::string::npos) << mesh;
  EXPECT_NE(mesh.find("size 2000 2000 2000\n"), std::string::npos) << mesh;
  EXPECT_NE(mesh.find("colours 4\n"), std::string::npos) << mesh;
  // The world's y points down and is the file's -z; x stays, z becomes y or -y.
  EXPECT_NE(mesh.find("at +x #C83C28\n"), std::string::npos) << mesh;
  EXPECT_NE(mesh.find("at -z #3CB44B\n"), std::string::npos) << mesh;
}

TEST(ThreeMf, WithoutColoursHasNoneAndKeepsEveryFloat) {
  if (!has_command("python3")) GTEST_SKIP() << "SKIPPED: python3 is not installed";
  const TemporaryFolder folder;
  write(test::cube(), folder / "m.3mf");
  const std::string mesh = told(folder / "m.3mf");
  EXPECT_NE(mesh.find("colours 0\n"), std::string::npos) << mesh;
  EXPECT_NE(mesh.find("volume +\n"), std::string::npos) << "outside is outside: " << mesh;
}

TEST(ThreeMf, AVolumesUnitIsTurnedIntoMillimetres) {
  if (!has_command("python3")) GTEST_SKIP() << "SKIPPED: python3 is not installed";
  const TemporaryFolder folder;
  write(test::cube(), folder / "m.3mf", 0.001);
  EXPECT_NE(told(folder / "m.3mf").find("size 2 2 2\n"), std::string::npos);
}

TEST(ThreeMf, IsTheSameBytesEveryTime) {
  const TemporaryFolder folder;
  write(test::marked_sphere(), folder / "a.3mf");
  write(test::marked_sphere(), folder / "b.3MF");
  EXPECT_EQ(test::read_text(folder / "a.3mf"), test::read_text(folder / "b.3MF"));
}

TEST(ThreeMf, TooLargeIsRefusedWithTheAlternative) {
  const TemporaryFolder folder;
  auto file = AtomicFile::create(folder / "m.3mf");
  ASSERT_TRUE(file);
  const auto written = write_3mf(test::cube(), {}, *file, 11);
  ASSERT_FALSE(written);
  EXPECT_NE(written.error().message.find("write STL or PLY"), std::string::npos) << written.error().message;
  EXPECT_FALSE(std::filesystem::exists(folder / "m.3mf"));
}

TEST(ThreeMf, ReadingOneIsRefusedWithTheAlternative) {
  const TemporaryFolder folder;
  write(test::cube(), folder / "m.3mf");
  const auto mesh = read_mesh(folder / "m.3mf");
  ASSERT_FALSE(mesh);
  EXPECT_NE(mesh.error().message.find("take the GLB or PLY"), std::string::npos) << mesh.error().message;
}

}  // namespace
}  // namespace scanknit
