// The placement of a mesh in each format, and the checks that all writers share.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

#include "core/axes.h"
#include "core/result.h"
#include "export/export_config.h"
#include "export/mesh/mesh_extension.h"
#include "export/mesh/write_mesh.h"
#include "export/placement.h"

namespace scanknit {

struct PlacementPlan {
  MeshFormat format;
  Placement placement;
  std::string convention;  ///< WrittenFile::convention
};

/// The rules of write_mesh().
[[nodiscard]] PlacementPlan plan_placement(MeshFormat format, const ExportConfig& config, UpAxis world_up,
                                           std::optional<double> file_unit_m);

/// Error kMesh for more than 2^31 - 1 vertices or triangles: PLY's indices are ints.
[[nodiscard]] Result<void> check_counts(std::size_t vertices, std::size_t triangles);

/// Describes the file written at `path`, with its size.
[[nodiscard]] WrittenFile written_file(const std::filesystem::path& path, const PlacementPlan& plan);

}  // namespace scanknit
