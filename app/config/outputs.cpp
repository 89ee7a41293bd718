#include "app/config/outputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>
#include <string>
#include <system_error>

#include "export/mesh/write_mesh.h"

namespace scanknit {
namespace {

using Path = std::filesystem::path;

/// True for file formats that ScanKnit does not write. A path with any other unknown extension names a folder.
bool is_foreign_file(const Path& path) {
  static constexpr std::array kEndings = {".gltf", ".fbx", ".dae", ".off", ".usd", ".usdz", ".vdb", ".png",
                                          ".json", ".txt", ".pcd", ".xyz", ".zip", ".step", ".stp"};
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c); });
  return std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end();
}

std::vector<Path> all_paths(const Outputs& outputs) {
  std::vector<Path> paths = all_paths(outputs.scan);
  for (const auto& path : {outputs.report, outputs.page}) {
    if (path) paths.push_back(*path);
  }
  return paths;
}

Result<void> refuse_repeated(const Outputs& outputs) {
  std::set<Path> seen;
  for (const Path& path : all_paths(outputs)) {
    if (!seen.insert(path.lexically_normal()).second) {
      return Error{ErrorCode::kUsage, "two outputs have this name", path.string()};
    }
  }
  return {};
}

}  // namespace

Result<Outputs> plan_outputs(const OutputRequest& request, const ExportConfig& config) {
  const Path& output = request.output;
  if (output.empty()) return Error{ErrorCode::kUsage, "-o is empty: give a folder, or a file such as model.glb"};
  std::error_code ignored;
  const bool is_folder = std::filesystem::is_directory(output, ignored);
  const bool is_file = is_tiles_path(output) || (is_mesh_path(output) && !is_folder);
  if (!is_folder && is_foreign_file(output)) {
    return Error{ErrorCode::kUsage,
                 "no such output: give a folder, or a file that ends in .glb, .ply, .obj, .stl, .3mf or .tiles",
                 output.string()};
  }
  if (!is_file && !is_folder && std::filesystem::exists(output, ignored)) {
    return Error{ErrorCode::kUsage, "exists and is not a folder; give another -o", output.string()};
  }
  Outputs outputs;
  if (is_file) {
    outputs.scan.meshes = {output};
  } else {
    for (const std::string& format : config.formats) outputs.scan.meshes.push_back(output / ("model." + format));
    if (config.preview) outputs.scan.preview = output / "preview.png";
    if (config.preview && request.has_trajectory) {
      outputs.scan.error = output / "error.png";
      outputs.scan.coverage = output / "coverage.png";
    }
    outputs.report = output / "report.json";
    outputs.page = output / "report.html";
    if (request.has_trajectory) outputs.scan.trajectory = output / "trajectory.txt";
  }
  if (request.report) outputs.report = request.report;
  if (request.trajectory) outputs.scan.trajectory = request.trajectory;
  outputs.scan.volume = request.volume;
  if (auto distinct = refuse_repeated(outputs); !distinct) return distinct.error();
  return outputs;
}

Result<void> refuse_texture(const ScanConfig& config, const char* command) {
  if (config.output.texture == TextureFormat::kOff) return {};
  return Error{
      ErrorCode::kConfig,
      fmt::format(
          "a texture is baked from the colour frames of one recording, by `run` and `capture`; `{}` bakes none: "
          "leave export.texture off, its meshes have colours at their vertices",
          command),
      "export.texture"};
}

void add_downloads(Outputs& outputs) {
  auto& meshes = outputs.scan.meshes;
  if (meshes.empty()) return;
  for (const char* extension : {".glb", ".stl"}) {
    const auto is_there =
        std::any_of(meshes.begin(), meshes.end(), [&](const Path& mesh) { return mesh.extension() == extension; });
    if (!is_there) meshes.push_back(Path(meshes.front()).replace_extension(extension));
  }
}

ScanJob job_of(const Path& input, const LoadedConfig& loaded, const Outputs& outputs) {
  ScanJob job{.input = input, .config = loaded.config, .asked_keys = loaded.asked, .files = outputs.scan};
  job.measures_fit = outputs.report.has_value();
  for (const auto& path : {outputs.report, outputs.page}) {
    if (path) job.files_of_caller.push_back(*path);
  }
  return job;
}

}  // namespace scanknit
