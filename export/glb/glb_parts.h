// Splits a mesh into the primitives of a GLB. Private to the GLB writer.
#pragma once

#include <numeric>
#include <optional>

#include "core/mesh.h"
#include "core/mesh/split_mesh.h"

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
  [[nodiscard]] MeshPart part(std::size_t i) {
    if (split_) return split_->part(i);
    MeshPart whole{std::vector<std::uint32_t>(mesh_.positions_m.size()), mesh_.triangles};
    std::iota(whole.vertices.begin(), whole.vertices.end(), 0u);
    return whole;
  }

 private:
  const Mesh& mesh_;
  std::optional<MeshSplit> split_;
};

}  // namespace scanknit
