// Writes a mesh: GLB, PLY, OBJ, STL, 3MF or 3D Tiles, by the file's extension.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "core/axes.h"
#include "core/mesh.h"
#include "core/result.h"
#include "export/export_config.h"

namespace scanknit {

struct MeshTexture;

struct WrittenFile {
  std::filesystem::path path;
  std::uintmax_t bytes = 0;
  std::string convention;  ///< "metres, Y up", "millimetres, Z up", "metres, the recording's world"
};

/// All-or-nothing. `world_up` is the world's own up axis (config.world_up overrides it). GLB: metres, +Y up,
/// right-handed, linear uint16 colours. PLY, OBJ: metres, the recording's world unless config.up. STL: millimetres, +Z
/// up, no colour. 3MF: the same, with colours. Tiles: write_tiles(), metres, +Z up. `file_unit_m`: the mesh has the
/// coordinates of a volume file, whose unit is so many metres (> 0). PLY, OBJ and STL then keep that unit; GLB and 3MF
/// are scaled. `texture`: written into GLB; null: none, as in the other formats. A scan bakes it
/// (ExportConfig::texture). A textured mesh has no colours: viewers would multiply them. `uncertainty_m`: one standard
/// deviation of each vertex, metres, NaN where unknown; PLY has it as the property `uncertainty`, whatever the unit of
/// the positions, the other formats leave it out. Empty: none. Errors: kMesh for an empty mesh, an index out of range,
/// a number that is not finite; kOutput for a failed write, an unknown extension (the message lists the known ones), a
/// file beyond the format's size limit.
[[nodiscard]] Result<WrittenFile> write_mesh(const Mesh& mesh, const std::filesystem::path& path,
                                             const ExportConfig& config, UpAxis world_up,
                                             std::optional<double> file_unit_m = std::nullopt,
                                             const MeshTexture* texture = nullptr,
                                             std::span<const float> uncertainty_m = {});

/// True for a path that ends in .glb, in any case.
[[nodiscard]] bool is_glb_path(const std::filesystem::path& path);

/// True for a path that ends in .tiles, in any case: a folder of 3D Tiles.
[[nodiscard]] bool is_tiles_path(const std::filesystem::path& path);

/// True for a path that ends in one of .glb .ply .obj .stl .3mf .tiles .step .stp, in any case.
[[nodiscard]] bool is_mesh_path(const std::filesystem::path& path);

}  // namespace scanknit
