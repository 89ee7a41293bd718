// A mesh as the primitives of a GLB. Private to the GLB writer.
#pragma once

#include <numeric>
#include <optional>

#include "core/mesh.h"
#include "core/mesh/split_mesh.h"

namespace scanknit {

/// One part with every vertex and triangle in their order where the mesh has no more than `most_vertices`; else boxes
/// of at most as many, in which vertices of no triangle are missing.
class GlbParts {
 public:
  /// `mesh` lives as long as this.
  GlbParts(const Mesh& mesh, std::size_t most_vertices) : mesh_(mesh) {
    if (mesh.positions_m.size() > most_vertices) split_.emplace(mesh, MostOfAPart{.vertices = most_vertices});
  }

  [[nodiscard]] std::size_t size() const { return split_ ? split_->parts() : 1; }
  /// Of all parts.
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
