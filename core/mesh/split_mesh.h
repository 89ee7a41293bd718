// Large meshes in parts, for what takes them one by one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/mesh.h"

namespace scanknit {

/// Some of a mesh's triangles. `vertices` are the mesh's numbers of those they have; `triangles` count in `vertices`.
struct MeshPart {
  std::vector<std::uint32_t> vertices;
  std::vector<Triangle> triangles;
};

/// Of one part; both are more than 0. A triangle is never cut: it is a part of its own where three vertices are too
/// many.
struct MostOfAPart {
  std::size_t triangles = std::numeric_limits<std::size_t>::max();
  std::size_t vertices = std::numeric_limits<std::size_t>::max();
};

/// A mesh cut into boxes, halved along their longest side until each holds no more than `most`. Parts have their own
/// copies of the vertices that they share; vertices of no triangle are in no part. In each part the triangles are in
/// the mesh's order, and the vertices in that in which they name them. Holds 4 bytes a triangle and 4 a vertex; the
/// parts are made when they are asked for.
class MeshSplit {
 public:
  /// `mesh` is well formed, and lives as long as this.
  MeshSplit(const Mesh& mesh, MostOfAPart most);

  [[nodiscard]] std::size_t parts() const { return parts_.size(); }
  /// Of all parts: those that are shared count in each.
  [[nodiscard]] std::size_t vertices() const;
  [[nodiscard]] MeshPart part(std::size_t i);

 private:
  struct Box {
    std::span<std::uint32_t> triangles;
    std::size_t vertices = 0;
  };
  [[nodiscard]] std::size_t count_vertices(std::span<const std::uint32_t> triangles);

  const Mesh& mesh_;
  std::vector<std::uint32_t> triangles_;
  std::vector<std::uint32_t> number_of_;  ///< as long as the mesh's vertices, and 0 throughout between calls
  std::vector<Box> parts_;
};

/// The parts as meshes, of at most `most_triangles` each.
[[nodiscard]] std::vector<Mesh> split_mesh(const Mesh& mesh, std::size_t most_triangles);

}  // namespace scanknit
