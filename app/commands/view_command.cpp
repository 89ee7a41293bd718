// view: shows a finished mesh in the browser.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/commands.h"
#include "app/exit_codes.h"
#include "app/terminal/signals.h"
#include "app/terminal/view_links.h"
#include "core/files/read_file.h"
#include "core/limits.h"
#include "core/mesh/split_mesh.h"
#include "export/mesh/read_mesh.h"
#include "export/mesh/up_rotation.h"
#include "export/report/report_page.h"
#include "extract/smooth_normals.h"
#include "view/mesh_chunk.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

/// The tileset.json of tiles: `given` is their folder, or the output folder with model.tiles; nothing: neither.
std::optional<fs::path> find_tileset(const fs::path& given) {
  std::error_code ignored;
  for (const fs::path& tileset : {given, given / "tileset.json", given / "model.tiles" / "tileset.json"}) {
    if (tileset.filename() == "tileset.json" && fs::is_regular_file(tileset, ignored)) return tileset;
  }
  return std::nullopt;
}

/// Its files, without those in other folders: ScanKnit writes none there.
std::vector<fs::path> files_of_tiles(const fs::path& tileset) {
  std::vector<fs::path> files = {tileset};
  std::error_code code;
  for (fs::directory_iterator entry(tileset.parent_path(), code), end; !code && entry != end; entry.increment(code)) {
    if (entry->path().extension() == ".glb") files.push_back(entry->path());
  }
  return files;
}

/// By what ScanKnit wrote into it; 0: unknown.
Result<std::size_t> triangles_of_tiles(const fs::path& tileset) {
  constexpr std::uintmax_t kMostBytes = 1u << 28;  // a million tiles
  const auto text = read_text_file(tileset, kMostBytes);
  if (!text) return text.error();
  const auto json = nlohmann::json::parse(*text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object() || !json.contains("root")) {
    return Error{ErrorCode::kInput, "is no tileset of 3D Tiles: write it again with export.formats=[tiles]",
                 tileset.string()};
  }
  if (json.contains("extensions")) {
    return Error{ErrorCode::kInput,
                 "its tiles are compressed, which the page cannot read: write them without export.compress",
                 tileset.string()};
  }
  const auto count = json.value(nlohmann::json::json_pointer("/asset/extras/triangles"), nlohmann::json());
  return count.is_number_unsigned() ? count.get<std::size_t>() : 0;
}

/// The mesh file: `given` itself, or the mesh in that folder.
Result<fs::path> find_mesh(const fs::path& given) {
  std::error_code ignored;
  if (!fs::exists(given, ignored)) return Error{ErrorCode::kInput, "no such file or folder", given.string()};
  if (!fs::is_directory(given, ignored)) return given;
  for (const char* name : {"model.glb", "model.ply", "model.obj", "model.stl"}) {
    if (fs::is_regular_file(given / name, ignored)) return given / name;
  }
  return Error{
      ErrorCode::kInput,
      "expected a folder with model.glb (or .ply, .obj, .stl), as `scanknit run ... -o OUT` writes it; to watch "
      "a recording being fused: scanknit run RECORDING -o OUT --view",
      given.string()};
}

/// The mesh in metres, with normals. `notes`: empty.
Result<Mesh> load(const fs::path& path, MeshNotes& notes, Console& console) {
  auto mesh = read_mesh(path, {}, &notes);
  if (!mesh) return mesh.error();
  for (const std::string& warning : notes.warnings) console.warn(fmt::format("{}: {}", path.string(), warning));
  if (mesh->empty()) return Error{ErrorCode::kMesh, "this mesh has no triangles", path.string()};
  if (path.extension() == ".stl") {  // STL files are in millimetres, as ScanKnit writes them and slicers read them
    for (Eigen::Vector3f& position : mesh->positions_m) position *= 1e-3f;
  }
  mesh->normals.resize(mesh->positions_m.size(), Eigen::Vector3f::Zero());
  fill_missing_normals(*mesh);
  return mesh;
}

/// The up axis of a mesh file that ScanKnit wrote.
UpAxis up_of(const fs::path& path, const ExportConfig& config) {
  if (path.extension() == ".glb") return UpAxis::kY;
  if (path.extension() == ".stl") return UpAxis::kZ;
  return config.up.value_or(config.world_up.value_or(UpAxis::kMinusY));
}

/// The voxel size of the run that wrote the mesh, by the report beside it; 0: unknown.
double voxel_size_of(const fs::path& path) {
  const auto text = read_text_file(path.parent_path() / "report.json", Limits{}.max_text_bytes);
  if (!text || !check_report(*text)) return 0;
  const auto report = nlohmann::json::parse(*text, nullptr, /*allow_exceptions=*/false);
  const auto files = report.find("files");
  if (files == report.end() || !files->is_object()) return 0;
  const bool is_of_mesh = std::any_of(files->begin(), files->end(), [&](const nlohmann::json& file) {
    return file.is_string() && fs::path(file.get<std::string>()).filename() == path.filename();
  });
  const auto size = report.value(nlohmann::json::json_pointer("/volume/voxel_size_m"), nlohmann::json());
  return is_of_mesh && size.is_number() ? std::max(size.get<double>(), 0.0) : 0;
}

/// What the page shows: a mesh that is sent to it, or the files of tiles, of which it takes those that it needs.
struct Shown {
  ViewHello hello;
  std::vector<fs::path> files;
  std::size_t triangles = 0;
  Mesh mesh = {};  ///< empty: tiles
  std::vector<float> uncertainty_m = {};
};

Result<Shown> shown_tiles(const fs::path& tileset) {
  const auto triangles = triangles_of_tiles(tileset);
  if (!triangles) return triangles.error();
  Shown shown{.hello = {}, .files = files_of_tiles(tileset), .triangles = *triangles};
  shown.hello.title = fs::absolute(tileset).parent_path().filename().string();
  shown.hello.up = Eigen::Vector3d::UnitZ();
  shown.hello.tiles = "/files/tileset.json";
  return shown;
}

Result<Shown> shown_mesh(const fs::path& given, const ExportConfig& config, Console& console) {
  const auto path = find_mesh(given);
  if (!path) return path.error();
  MeshNotes notes;
  auto mesh = load(*path, notes, console);
  if (!mesh) return mesh.error();
  Shown shown{.hello = {},
              .files = {*path},
              .triangles = mesh->triangles.size(),
              .mesh = *std::move(mesh),
              .uncertainty_m = std::move(notes.uncertainty_m)};
  shown.hello.title = path->filename().string();
  shown.hello.up = direction(up_of(*path, config)).cast<double>();
  shown.hello.voxel_size_m = voxel_size_of(*path);
  return shown;
}

Result<Shown> shown_of(const fs::path& given, const ExportConfig& config, Console& console) {
  const auto tileset = find_tileset(given);
  auto shown = tileset ? shown_tiles(*tileset) : shown_mesh(given, config, console);
  if (shown) shown->hello.mode = "file";
  return shown;
}

void publish(const Mesh& mesh, const std::vector<float>& uncertainty_m, LiveView& view) {
  constexpr std::size_t kTrianglesOfAPiece = 30'000;
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& position : mesh.positions_m) box.extend(position);
  const float step_m = step_for(box.sizes().maxCoeff());
  MeshSplit split(mesh, {.triangles = kTrianglesOfAPiece});
  for (std::uint32_t i = 0; i < split.parts(); ++i) {
    MeshPart part = split.part(i);
    ChunkPart shown;
    if (!uncertainty_m.empty()) {
      for (const std::uint32_t vertex : part.vertices) shown.uncertainty_m.push_back(uncertainty_m[vertex]);
    }
    const Mesh piece = mesh_of_part(mesh, std::move(part));
    shown.mesh = &piece;
    view.publish_chunk(i + 1, chunk_message(i + 1, 1, {&shown, 1}, step_m));
  }
}

}  // namespace

int view_command(const ShowArguments& arguments, const CommonArguments& common) {
  const StopOnSignal stop_on_signal;  // must come before any other thread
  const auto loaded = load_config(with_run_defaults(common.config));
  if (!loaded) return fail(loaded.error(), common);
  Console console(common.verbosity);
  const auto shown = shown_of(arguments.file, loaded->config.output, console);
  if (!shown) return fail(shown.error(), common);

  auto view = LiveView::start(arguments.server, shown->hello);
  if (!view) return fail(view.error(), common);
  ViewState state;
  state.phase = ViewPhase::kFinished;
  state.triangles = shown->triangles;
  (*view)->publish(state);
  (*view)->publish_files(shown->files);
  if (!shown->mesh.empty()) publish(shown->mesh, shown->uncertainty_m, **view);

  announce((*view)->links(), console);
  console.info("Ctrl-C ends it");
  using namespace std::chrono_literals;
  while (!stop_on_signal.token().stop_requested()) {
    if (const auto command = (*view)->next_command(stop_on_signal.token(), 1s))
      (*view)->answer(*command, "this is a finished mesh");
  }
  return kExitOk;
}

}  // namespace scanknit
