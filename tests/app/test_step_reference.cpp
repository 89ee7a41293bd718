// `distance` with a STEP model as the reference, as a user calls it.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "export/export_config.h"
#include "export/mesh/read_mesh.h"
#include "export/mesh/write_mesh.h"
#include "tests/app/program.h"
#include "tests/core/temporary_folder.h"
#include "tests/export/step_models.h"

namespace scanknit {
namespace {

using namespace test;

TEST(StepReference, IsComparedInTheUnitThatItStates) {
  const TemporaryFolder folder;
  const std::string model = (folder / "block.step").string();
  ASSERT_NO_FATAL_FAILURE(write_step(bored_block(), "INCH", model));
  auto mesh = read_mesh(model);
  ASSERT_TRUE(mesh) << mesh.error().text();
  const auto write = [&](const char* name) {
    const auto written = write_mesh(*mesh, folder / name, ExportConfig(), UpAxis::kZ, 1.0);
    ASSERT_TRUE(written) << written.error().text();
  };
  write("in_mm.stl");
  const Outcome same = scanknit_command({"distance", (folder / "in_mm.stl").string(), model, "--tolerance", "0.001mm"});
  EXPECT_EQ(same.exit_code, 0) << same.err;
  for (Eigen::Vector3f& p : mesh->positions_m) p /= 25.4F;
  write("in_inches.stl");
  const Outcome asked = scanknit_command({"distance", (folder / "in_inches.stl").string(), model});
  EXPECT_EQ(asked.exit_code, 4);
  EXPECT_NE(asked.err.find("--mesh-unit inch"), std::string::npos) << asked.err;
  const Outcome told = scanknit_command(
      {"distance", (folder / "in_inches.stl").string(), model, "--mesh-unit", "inch", "--tolerance", "0.001mm"});
  EXPECT_EQ(told.exit_code, 0) << told.err;
}

}  // namespace
}  // namespace scanknit
