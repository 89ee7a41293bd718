#include "export/tiles/write_tiles.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <exception>
#include <new>
#include <system_error>
#include <utility>
#include <vector>

#include "core/files/atomic_file.h"
#include "core/files/located.h"
#include "core/files/part_folder.h"
#include "core/mesh/split_mesh.h"
#include "export/glb/glb_writer.h"
#include "export/mesh/read_mesh.h"
#include "export/tiles/simplify_tile.h"
#include "export/tiles/tile_tree.h"
#include "export/tiles/tileset_json.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTileset = "tileset.json";

/// A subtree whose files are written.
struct BuiltTile {
  WrittenTile tile;
  std::vector<Triangle> triangles;  ///< of the mesh's vertices, as the tile shows them
};

class TileBuilder {
 public:
  TileBuilder(const Mesh& mesh, const TileTree& tree, const Placement& placement, const ExportConfig& config,
              const fs::path& folder, std::size_t most_triangles)
      : mesh_(mesh),
        tree_(tree),
        placement_(placement),
        config_(config),
        folder_(folder),
        most_triangles_(most_triangles) {
    config_.quantize = false;
  }

  [[nodiscard]] Result<BuiltTile> build(const TileNode& node) const {
    BuiltTile built;
    built.tile.uri = node.name + ".glb";
    if (node.children.empty()) {
      built.triangles.reserve(node.triangles.size());
      for (const std::uint32_t triangle : node.triangles) built.triangles.push_back(mesh_.triangles[triangle]);
    } else if (auto united = unite_children(node, built); !united) {
      return united.error();
    }
    if (auto written = write(built); !written) return written.error();
    return built;
  }

 private:
  [[nodiscard]] Result<void> unite_children(const TileNode& node, BuiltTile& built) const {
    std::vector<Result<BuiltTile>> children(node.children.size(), BuiltTile{});
    tbb::parallel_for(std::size_t{0}, children.size(), [&](std::size_t i) { children[i] = build(node.children[i]); });
    std::vector<Triangle> fine;
    for (auto& child : children) {
      if (!child) return child.error();
      fine.insert(fine.end(), child->triangles.begin(), child->triangles.end());
      child->triangles = {};
      built.tile.error_m = std::max(built.tile.error_m, child->tile.error_m);
      built.tile.box.extend(child->tile.box);
      built.tile.children.push_back(std::move(child->tile));
    }
    const std::size_t target = std::min(most_triangles_, fine.size() / 2);
    CoarseTile coarse = simplify_tile(mesh_, std::move(fine), target,
                                      [&](std::uint32_t vertex) { return tree_.is_shared(vertex, node); });
    built.triangles = std::move(coarse.triangles);
    built.tile.error_m += coarse.error * static_cast<double>(placement_.scale);
    return {};
  }

  [[nodiscard]] Result<void> write(BuiltTile& built) const {
    const Mesh part = mesh_of_part(mesh_, part_of(built.triangles));
    for (const Eigen::Vector3f& p : part.positions_m) built.tile.box.extend(placement_.position(p));
    auto file = AtomicFile::create(folder_ / built.tile.uri);
    if (!file) return file.error();
    if (auto written = write_glb({part, placement_}, config_, *file); !written) return written;
    return file->commit();
  }

  const Mesh& mesh_;
  const TileTree& tree_;
  const Placement& placement_;
  ExportConfig config_;
  fs::path folder_;
  std::size_t most_triangles_;
};

/// Reads the root's tile: what it must show is still in memory.
Result<void> check_root(const BuiltTile& root, const fs::path& folder) {
  const auto read = read_mesh(folder / root.tile.uri);
  if (!read) return read.error();
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : read->positions_m) box.extend(p);
  if (read->triangles.size() == root.triangles.size() && root.tile.box.contains(box)) return {};
  return Error{ErrorCode::kOutput, fmt::format("the tile {} was read back with other content", root.tile.uri)};
}

std::uintmax_t bytes_in(const fs::path& folder) {
  std::uintmax_t bytes = 0;
  std::error_code code;
  for (fs::directory_iterator entry(folder, code), end; !code && entry != end; entry.increment(code)) {
    std::error_code none;
    const std::uintmax_t size = entry->file_size(none);
    if (!none) bytes += size;
  }
  return bytes;
}

/// Only a folder of tiles, or an empty one, is replaced.
Result<void> check_replaceable(const fs::path& folder) {
  std::error_code code;
  if (!fs::exists(fs::symlink_status(folder, code))) return {};
  if (!fs::is_directory(fs::symlink_status(folder, code))) {
    return Error{ErrorCode::kOutput, "is no folder: tiles are a folder, which would take its place", folder.string()};
  }
  if (fs::exists(folder / kTileset, code) || fs::is_empty(folder, code)) return {};
  return Error{ErrorCode::kOutput, "is a folder without tileset.json: only a folder of tiles is replaced; give another",
               folder.string()};
}

Result<std::uintmax_t> write_folder(const Mesh& mesh, const PlacementPlan& plan, const ExportConfig& config,
                                    const fs::path& folder, std::size_t most_triangles) {
  if (auto fits = check_replaceable(folder); !fits) return fits.error();
  auto made = PartFolder::create(folder);
  if (!made) return made.error();
  const TileTree tree(mesh, most_triangles);
  const TileBuilder builder(mesh, tree, plan.placement, config, made->path(), most_triangles);
  const auto root = builder.build(tree.root());
  if (!root) return root.error();
  if (auto checked = check_root(*root, made->path()); !checked) return checked.error();
  const std::string json = tileset_json(root->tile, mesh.triangles.size(), config);
  if (auto written = write_file_atomically(made->path() / kTileset, json); !written) return written.error();
  const std::uintmax_t bytes = bytes_in(made->path());
  if (auto named = made->replace(folder); !named) return named.error();
  return bytes;
}

}  // namespace

Result<WrittenFile> write_tiles(const Mesh& mesh, const PlacementPlan& plan, const ExportConfig& config,
                                const fs::path& folder, std::size_t most_triangles) {
  try {
    const auto bytes = write_folder(mesh, plan, config, folder, most_triangles);
    if (!bytes) return Error{bytes.error().code, bytes.error().message, folder.string()};
    return WrittenFile{folder, *bytes, plan.convention};
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kBudget, "out of memory while the tiles were built; a file .ply needs less",
                 folder.string()};
  } catch (const std::exception& problem) {
    return Error{ErrorCode::kOutput, std::string("the tiles could not be built: ") + problem.what(), folder.string()};
  }
}

Result<void> check_tiles_writable(const fs::path& folder) {
  if (auto fits = check_replaceable(folder); !fits) return fits;
  fs::path beside = folder;
  beside += ".check";  // as long as the folder is there, its own name cannot be tried
  auto writable = check_writable(beside);
  if (!writable) return Error{writable.error().code, writable.error().message, folder.string()};
  return {};
}

}  // namespace scanknit
