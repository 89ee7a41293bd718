// Writes points without triangles: PLY or PCD, by the file's extension.
#pragma once

#include <filesystem>

#include "core/mesh.h"
#include "core/result.h"

namespace scanknit {

/// Writes the vertices, with normals and colours if there are any; ignores triangles. Binary, metres, in the world's
/// coordinates. PCD: version 0.7, fields x y z [normal_x normal_y normal_z] [rgb], one row. All-or-nothing. Errors
/// (kOutput): another extension, no point, a failed write.
[[nodiscard]] Result<void> write_points(const Mesh& points, const std::filesystem::path& path);

/// True for a path that ends in .ply or .pcd.
[[nodiscard]] bool is_points_path(const std::filesystem::path& path);

}  // namespace scanknit
