// Khronos' own validator on what we write. Needs node, and `npm ci` of tests/export/package.json into build/npm.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstdlib>

#include "export/write_mesh.h"
#include "tests/core/temporary_folder.h"
#include "tests/export/export_samples.h"

namespace scanknit {
namespace {

using test::TemporaryFolder;

constexpr int kSkipped = 77;
constexpr int kNoSuchCommand = 127;

struct Verdict {
  int exit_code = 0;
  std::string issues;
};

Verdict validate(const std::filesystem::path& file) {
  const std::string command = "node '" SCANKNIT_SOURCE_DIR "/tests/export/validate_glb.mjs' '" SCANKNIT_NPM_DIR "' '" +
                              file.string() + "' 2>&1";
  Verdict verdict;
  FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) return {kNoSuchCommand, {}};
  std::array<char, 4096> block{};
  while (std::fgets(block.data(), static_cast<int>(block.size()), pipe) != nullptr) verdict.issues += block.data();
  const int status = ::pclose(pipe);
  verdict.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 1;
  return verdict;
}

void expect_valid(const Mesh& mesh, Material material) {
  const TemporaryFolder folder;
  ExportConfig config;
  config.material = material;
  ASSERT_TRUE(write_mesh(mesh, folder / "m.glb", config, UpAxis::kMinusY));
  const Verdict verdict = validate(folder / "m.glb");
  if (verdict.exit_code == kSkipped || verdict.exit_code == kNoSuchCommand) {
    GTEST_SKIP() << "SKIPPED: node or gltf-validator is not installed (npm ci in " SCANKNIT_NPM_DIR ")";
  }
  EXPECT_EQ(verdict.exit_code, 0) << verdict.issues;
  EXPECT_EQ(verdict.issues, "");
}

TEST(GlbValidator, FindsNothingInALitMesh) {
  expect_valid(test::marked_sphere(), Material::kLit);
}

TEST(GlbValidator, FindsNothingInAnUnlitMesh) {
  expect_valid(test::marked_sphere(), Material::kUnlit);
}

TEST(GlbValidator, FindsNothingInAMeshWithoutColours) {
  expect_valid(test::sphere(), Material::kLit);
}

TEST(GlbValidator, FindsNothingInAMeshWithoutNormals) {
  Mesh mesh = test::marked_sphere();
  mesh.normals.clear();
  expect_valid(mesh, Material::kLit);
}

TEST(GlbValidator, FindsNothingInABareMesh) {
  expect_valid(test::tetrahedron(), Material::kUnlit);
}

TEST(GlbValidator, FindsNothingInUnknownNormals) {
  Mesh mesh = test::small_mesh();
  mesh.normals[1].setZero();
  expect_valid(mesh, Material::kLit);
}

}  // namespace
}  // namespace scanknit
