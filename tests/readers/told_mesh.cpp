#include "tests/readers/told_mesh.h"

#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/mesh/split_mesh.h"
#include "export/mesh/write_mesh.h"

namespace scanknit::test {

bool has_command(const std::string& name) {
  return run("command -v " + name).exit_code == 0;
}

Said run(const std::string& command) {
  Said said;
  FILE* pipe = ::popen(("{ " + command + "; } 2>&1").c_str(), "r");
  if (pipe == nullptr) return {-1, "no process"};
  std::array<char, 4096> block{};
  while (std::fgets(block.data(), static_cast<int>(block.size()), pipe) != nullptr) said.text += block.data();
  const int status = ::pclose(pipe);
  said.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return said;
}

std::string debian_python() {
  return std::filesystem::exists("/usr/bin/python3") ? "/usr/bin/python3" : "python3";
}

ToldMesh told_in_json(const std::filesystem::path& json_file) {
  const auto json = nlohmann::json::parse(std::ifstream(json_file));
  ToldMesh told;
  for (const auto& v : json.at("vertices")) told.positions.emplace_back(v.at(0), v.at(1), v.at(2));
  for (const auto& c : json.at("colours")) {
    told.colours.emplace_back(255 * Eigen::Vector3d(c.at(0), c.at(1), c.at(2)));
  }
  for (const auto& t : json.at("triangles")) told.triangles.emplace_back(t.at(0), t.at(1), t.at(2));
  return told;
}

WrittenMesh::WrittenMesh(const Mesh& mesh, const std::string& name, const ExportConfig& config,
                         const MeshTexture* texture)
    : file_(name) {
  const auto written = write_mesh(mesh, path(), config, UpAxis::kMinusY, std::nullopt, texture);
  EXPECT_TRUE(written) << (written ? "" : written.error().text());
}

namespace {

constexpr std::size_t kVerticesOfAPrimitive = 300;

Mesh without_colours(Mesh mesh) {
  mesh.colours.clear();
  return mesh;
}

}  // namespace

ExportConfig in_primitives() {
  ExportConfig config;
  config.max_vertices_of_a_primitive = kVerticesOfAPrimitive;
  return config;
}

std::size_t vertices_in_primitives(const Mesh& mesh) {
  MeshSplit split(mesh, {.vertices = kVerticesOfAPrimitive});
  EXPECT_GT(split.parts(), 3u);
  return split.vertices();
}

TexturedFile::TexturedFile(const Mesh& mesh, const ExportConfig& config)
    : texels_(own_texels(mesh)), file_(without_colours(mesh), "m.glb", config, &texels_.texture) {}

Eigen::Matrix3d as_it_is() {
  return Eigen::Matrix3d::Identity();
}

Eigen::Matrix3d y_up() {
  return Eigen::Vector3d(1, -1, -1).asDiagonal();
}

Eigen::Matrix3d z_up() {
  Eigen::Matrix3d rows;
  rows << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  return rows;
}

}  // namespace scanknit::test
