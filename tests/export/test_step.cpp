// STEP models that Open CASCADE writes, read as meshes; and files that are none.
#include <gtest/gtest.h>

#include <BRepPrimAPI_MakeSphere.hxx>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>

#include "core/files/read_file.h"
#include "core/mesh.h"
#include "export/mesh/read_mesh.h"
#include "measure/solid/volume.h"
#include "tests/core/temporary_folder.h"
#include "tests/export/step_models.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using namespace test;

TEST(Step, IsAClosedMeshInMillimetresWhateverItsUnit) {
  constexpr double kTrue_mm3 = 60 * 40 * 20 - std::numbers::pi * 10 * 10 * 20;
  for (const char* unit : {"MM", "M", "INCH"}) {
    const TemporaryFolder folder;
    const fs::path file = folder / "block.step";
    ASSERT_NO_FATAL_FAILURE(write_step(bored_block(), unit, file));
    MeshNotes notes;
    const auto mesh = read_mesh(file, {}, &notes);
    ASSERT_TRUE(mesh) << unit << ": " << mesh.error().text();
    EXPECT_TRUE(notes.warnings.empty());
    const MeshCheck check = check_mesh(*mesh);
    EXPECT_TRUE(check.is_closed() && check.is_manifold()) << unit;
    EXPECT_EQ(check.euler, 0) << "one tunnel";
    const MeshVolume volume = measure_volume(*mesh);
    EXPECT_FALSE(volume.is_inside_out);
    EXPECT_NEAR(volume.volume_m3.value_or(0), kTrue_mm3, 2e-4 * kTrue_mm3) << unit << ": but for the bore's chords";
    const Eigen::Vector3f size = check.max_m - check.min_m;
    EXPECT_TRUE(size.isApprox(Eigen::Vector3f(60, 40, 20), 1e-5F)) << unit << ": " << size.transpose();
  }
}

TEST(Step, LiesWithinTheStatedDistanceOfItsSurface) {
  constexpr double kRadius_mm = 50;
  const TemporaryFolder folder;
  const fs::path file = folder / "ball.stp";
  ASSERT_NO_FATAL_FAILURE(write_step(BRepPrimAPI_MakeSphere(kRadius_mm).Shape(), "MM", file));
  const auto mesh = read_mesh(file);
  ASSERT_TRUE(mesh) << mesh.error().text();
  EXPECT_TRUE(check_mesh(*mesh).is_closed());
  const double most_mm = 1e-4 * 2 * kRadius_mm * std::sqrt(3.0);
  for (const Triangle& t : mesh->triangles) {
    const Eigen::Vector3f middle = (mesh->positions_m[t[0]] + mesh->positions_m[t[1]] + mesh->positions_m[t[2]]) / 3;
    ASSERT_NEAR(static_cast<double>(middle.norm()), kRadius_mm, most_mm);
  }
}

TEST(Step, ABrokenFileIsAnError) {
  const TemporaryFolder folder;
  const fs::path file = folder / "block.step";
  ASSERT_NO_FATAL_FAILURE(write_step(bored_block(), "MM", file));
  const auto text = read_text_file(file, 1u << 20);
  ASSERT_TRUE(text);
  const auto read = [&](const std::string& bytes) {
    std::ofstream(file, std::ios::binary) << bytes;
    return read_mesh(file);
  };
  for (const std::string& bytes :
       {std::string(), std::string("solid a\nendsolid a\n"), text->substr(0, text->size() / 2),
        text->substr(0, text->find("DATA;") + 6) + "ENDSEC;\nEND-ISO-10303-21;\n"}) {
    const auto mesh = read(bytes);
    ASSERT_FALSE(mesh) << bytes.size() << " bytes";
    EXPECT_EQ(mesh.error().code, ErrorCode::kInput);
    EXPECT_NE(mesh.error().text().find("STEP"), std::string::npos) << mesh.error().text();
    EXPECT_NE(mesh.error().text().find(file.string()), std::string::npos) << mesh.error().text();
  }
}

TEST(Step, AFaceThatCannotBeReadIsSaid) {
  const TemporaryFolder folder;
  const fs::path file = folder / "block.step";
  ASSERT_NO_FATAL_FAILURE(write_step(bored_block(), "MM", file));
  auto text = read_text_file(file, 1u << 20);
  ASSERT_TRUE(text);
  const std::size_t bore = text->find(",10.)", text->find("CYLINDRICAL_SURFACE"));
  ASSERT_NE(bore, std::string::npos);
  text->replace(bore, 5, ",-10.)");
  std::ofstream(file, std::ios::binary) << *text;
  MeshNotes notes;
  const auto mesh = read_mesh(file, {}, &notes);
  ASSERT_TRUE(mesh) << mesh.error().text();
  ASSERT_EQ(notes.warnings.size(), 1U);
  EXPECT_EQ(notes.warnings.front(), "faces of the STEP model that cannot be meshed are left out: 1");
}

TEST(Step, NoChangedNumberCrashes) {
  const TemporaryFolder folder;
  const fs::path file = folder / "block.step";
  ASSERT_NO_FATAL_FAILURE(write_step(bored_block(), "MM", file));
  const auto text = read_text_file(file, 1u << 20);
  ASSERT_TRUE(text);
  std::size_t tried = 0;
  for (std::size_t at = text->find("DATA;"); at < text->size() && tried < 60; at += text->size() / 61) {
    std::string changed = *text;
    const std::size_t digit = changed.find_first_of("123456789", at);
    if (digit == std::string::npos) break;
    changed[digit] = changed[digit] == '9' ? '1' : '9';
    std::ofstream(file, std::ios::binary) << changed;
    const auto mesh = read_mesh(file);  // a mesh or an error; not the end of this process
    EXPECT_TRUE(mesh || mesh.error().code == ErrorCode::kInput) << mesh.error().text();
    ++tried;
  }
  EXPECT_GT(tried, 30U);
}

}  // namespace
}  // namespace scanknit
