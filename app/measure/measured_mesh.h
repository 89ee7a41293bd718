// Reads a mesh to measure it: in metres, and as one surface.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/mesh.h"
#include "core/result.h"
#include "measure/mesh_unit.h"

namespace scanknit {

struct MeasuredMesh {
  Mesh mesh;  ///< metres, the file's axes
  MeshUnit unit = MeshUnit::kMetre;
  bool is_unit_given = false;         ///< by the caller
  bool is_unit_stated = false;        ///< by the file: STEP
  std::vector<std::string> warnings;  ///< of parts of the file that were not read
};

/// The unit of a mesh's numbers where none is given: STL and STEP millimetres, all other formats metres, as ScanKnit
/// writes them.
[[nodiscard]] MeshUnit usual_unit(const std::filesystem::path& file);

/// Joins the seams of a texture, and leaves out vertices without a triangle. Errors: kInput
/// as read_mesh(); kMesh: no triangles, or no area.
[[nodiscard]] Result<MeasuredMesh> read_measured_mesh(const std::filesystem::path& file, std::optional<MeshUnit> unit);

}  // namespace scanknit
