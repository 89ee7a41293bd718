// Splits large meshes into parts, to process them one by one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/mesh.h"

namespace scanknit {

/// Some of a mesh's triangles. `vertices` are the mesh's numbers of their vertices; `triangles` index into `vertices`.
struct MeshPart {
  std::vector<std::uint32_t> vertices;
  std::vector<Triangle> triangles;
};

/// The largest size of a part; both numbers are > 0. Triangles are never cut: if three vertices are too many, each
/// triangle is a part of its own.
struct MostOfAPart {
  std::size_t triangles = std::numeric_limits<std::size_t>::max();
  std::size_t vertices = std::numeric_limits<std::size_t>::max();
};

/// Splits a mesh into boxes, halved along their longest side until each has at most `most`. Each part has its own copy
/// of shared vertices; vertices without a triangle are in no part. In each part the triangles are in the mesh's order,
/// and the vertices in the order of their first use. Needs 4 bytes for each triangle and 4 for each vertex; makes the
/// parts on demand.
class MeshSplit {
 public:
  /// `mesh` is well formed and outlives this object.
  MeshSplit(const Mesh& mesh, MostOfAPart most);

  [[nodiscard]] std::size_t parts() const { return parts_.size(); }
  /// The number of vertices in all parts; shared ones count in each.
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
  std::vector<std::uint32_t> number_of_;  ///< one entry for each vertex of the mesh; all 0 between calls
  std::vector<Box> parts_;
};

/// Triangles that index into a mesh as a part of it, in their order; the vertices ascend.
[[nodiscard]] MeshPart part_of(std::span<const Triangle> triangles);

/// A part as a mesh of its own.
[[nodiscard]] Mesh mesh_of_part(const Mesh& mesh, MeshPart part);

/// The parts as meshes with at most `most_triangles` each.
[[nodiscard]] std::vector<Mesh> split_mesh(const Mesh& mesh, std::size_t most_triangles);

}  // namespace scanknit
