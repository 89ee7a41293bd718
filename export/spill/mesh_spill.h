// MeshSpill: collects a mesh larger than memory on disk, part by part, then writes it as PLY or STL.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <filesystem>
#include <optional>

#include "core/axes.h"
#include "core/mesh.h"
#include "core/result.h"
#include "export/export_config.h"
#include "export/mesh/write_mesh.h"
#include "export/spill/spill_file.h"

namespace scanknit {

/// Needs memory for one part and a few megabytes. No colours.
class MeshSpill {
 public:
  /// Needs as much space in `folder` as the final mesh. Errors: kOutput.
  [[nodiscard]] static Result<MeshSpill> create(const std::filesystem::path& folder);

  /// Appends vertices, with normals in every part or in none, and triangles whose indices count from the first part's
  /// first vertex; they may use vertices of any part, also of later ones. Errors: kOutput; kMesh for a position or
  /// normal that is not finite.
  [[nodiscard]] Result<void> add(const Mesh& part);

  [[nodiscard]] std::size_t vertices() const { return vertices_; }
  [[nodiscard]] std::size_t triangles() const { return triangles_; }
  [[nodiscard]] const Eigen::AlignedBox3f& bounds() const { return bounds_; }

  /// Writes, all or nothing, the same bytes as write_mesh() for the whole mesh; the other arguments are those of
  /// write_mesh(). Errors: kBudget for a format that cannot be written part by part (GLB, OBJ); those of write_mesh().
  [[nodiscard]] Result<WrittenFile> write(const std::filesystem::path& path, const ExportConfig& config,
                                          UpAxis world_up, std::optional<double> file_unit_m = std::nullopt) const;

  /// For pictures: joins vertices until at most `most_vertices` (a thousand or more) are left, and needs memory for so
  /// many. Errors: kOutput; kMesh for an empty mesh, or a triangle with a vertex that does not exist.
  [[nodiscard]] Result<Mesh> coarse(std::size_t most_vertices) const;

 private:
  MeshSpill(SpillFile vertex_file, SpillFile triangle_file);

  SpillFile vertex_file_;    ///< position and, if there is one, normal of each vertex, as floats
  SpillFile triangle_file_;  ///< Triangles
  std::size_t vertices_ = 0;
  std::size_t triangles_ = 0;
  bool has_normals_ = false;
  Eigen::AlignedBox3f bounds_;
};

/// True for PLY and STL.
[[nodiscard]] bool can_be_written_in_parts(const std::filesystem::path& path);

}  // namespace scanknit
