// Splits a mesh into the primitives of a GLB. Private to the GLB writer.
#pragma once

#include <numeric>
#include <optional>

#include "core/mesh.h"
#include "core/mesh/split_mesh.h"
#include "export/glb/glb_arrays.h"

namespace scanknit {

/// If the mesh has at most `most_vertices`: one part with all vertices and triangles in their order. Else boxes with at
/// most so many vertices, without the vertices that no triangle uses.
class GlbParts {
 public:
  /// `mesh` outlives this object.
  GlbParts(const Mesh& mesh, std::size_t most_vertices) : mesh_(mesh) {
    if (mesh.positions_m.size() > most_vertices) split_.emplace(mesh, MostOfAPart{.vertices = most_vertices});
  }

  [[nodiscard]] std::size_t size() const { return split_ ? split_->parts() : 1; }
  /// The number of vertices in all parts.
  [[nodiscard]] std::size_t vertices() const { return split_ ? split_->vertices() : mesh_.positions_m.size(); }
  /// Valid until the next call. The same part may be asked for again.
  [[nodiscard]] GlbPart part(std::size_t i) {
    if (split_) {
      part_ = split_->part(i);
      return {part_.vertices, part_.triangles};
    }
    if (part_.vertices.empty()) {
      part_.vertices.resize(mesh_.positions_m.size());
      std::iota(part_.vertices.begin(), part_.vertices.end(), 0u);
    }
    return {part_.vertices, mesh_.triangles};
  }

 private:
  const Mesh& mesh_;
  std::optional<MeshSplit> split_;
  MeshPart part_;  ///< the last one; its triangles are none if they are the mesh's
};

}  // namespace scanknit
