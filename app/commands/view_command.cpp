// view: shows a finished mesh in the browser.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "app/commands.h"
#include "app/exit_codes.h"
#include "app/terminal/signals.h"
#include "app/terminal/view_links.h"
#include "core/mesh/split_mesh.h"
#include "export/mesh/read_mesh.h"
#include "export/mesh/up_rotation.h"
#include "extract/smooth_normals.h"
#include "view/mesh_chunk.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

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

/// The mesh in metres, with normals.
Result<Mesh> load(const fs::path& path, Console& console) {
  MeshNotes notes;
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

void publish(const Mesh& mesh, LiveView& view) {
  constexpr std::size_t kTrianglesOfAPiece = 30'000;
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& position : mesh.positions_m) box.extend(position);
  const float step_m = step_for(box.sizes().maxCoeff());
  std::uint32_t number = 0;
  for (const Mesh& piece : split_mesh(mesh, kTrianglesOfAPiece)) {
    const ChunkPart part{&piece, {}};
    ++number;
    view.publish_chunk(number, chunk_message(number, 1, {&part, 1}, step_m));
  }
}

}  // namespace

int view_command(const ShowArguments& arguments, const CommonArguments& common) {
  const StopOnSignal stop_on_signal;  // must come before any other thread
  const auto loaded = load_config(with_run_defaults(common.config));
  if (!loaded) return fail(loaded.error(), common);
  const auto path = find_mesh(arguments.file);
  if (!path) return fail(path.error(), common);
  Console console(common.verbosity);
  const auto mesh = load(*path, console);
  if (!mesh) return fail(mesh.error(), common);

  ViewHello hello;
  hello.title = path->filename().string();
  hello.mode = "file";
  hello.up = direction(up_of(*path, loaded->config.output)).cast<double>();
  auto view = LiveView::start(arguments.server, hello);
  if (!view) return fail(view.error(), common);
  ViewState state;
  state.phase = ViewPhase::kFinished;
  state.triangles = mesh->triangles.size();
  (*view)->publish(state);
  (*view)->publish_files({*path});
  publish(*mesh, **view);

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
