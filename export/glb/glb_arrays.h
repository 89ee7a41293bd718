// The arrays of a GLB primitive, as the file stores them: positions, normals, colours, texture coordinates, indices.
// Private to the GLB writer.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "core/mesh.h"
#include "export/glb/glb_writer.h"
#include "export/placement.h"

namespace scanknit {

/// Refers to a part of a mesh: the mesh's numbers of its vertices, and triangles that count these.
struct GlbPart {
  std::span<const std::uint32_t> vertices;
  std::span<const Triangle> triangles;
};

/// An array, with the values of its accessor and its buffer view (glTF 2.0, 3.6.2).
struct GlbArray {
  std::string_view attribute;  ///< "POSITION", "NORMAL", "COLOR_0" or "TEXCOORD_0"; empty: the indices
  std::string_view type;       ///< "SCALAR", "VEC2", "VEC3" or "VEC4"
  int component_type = 0;
  bool is_normalised = false;  ///< integers represent 0..1 or -1..1
  std::size_t stride = 0;      ///< bytes of an element, a multiple of four
  std::size_t count = 0;
  std::vector<double> lowest = {}, highest = {};  ///< for positions: limits along each axis, exactly as stored
  std::span<const unsigned char> bytes = {};      ///< byte_length() of them, or none: GlbBytes::kLeftOut
  std::vector<unsigned char> own_bytes = {};      ///< what `bytes` refers to, unless it is the mesh

  [[nodiscard]] std::size_t byte_length() const { return stride * count; }
  [[nodiscard]] bool is_indices() const { return attribute.empty(); }
};

/// The grid of a quantized mesh's positions: p = origin + side * stored / 65535. All axes have the same scale, so that
/// the directions of normals do not change.
struct QuantizationGrid {
  Eigen::Vector3f origin_m = Eigen::Vector3f::Zero();
  float side_m = 1;
};

/// The grid of the whole mesh, so that common vertices have the same position in all primitives. The mesh has a vertex.
[[nodiscard]] QuantizationGrid quantization_grid(const Mesh& mesh, const Placement& placement);

enum class GlbBytes { kMade, kLeftOut };

/// Calls `take` with one array for each attribute of the vertices of `part`, then with the indices. Only one array is
/// in memory at a time. `grid`: null for floats.
void for_each_array(const GlbContents& contents, const GlbPart& part, const QuantizationGrid* grid, GlbBytes bytes,
                    const std::function<void(const GlbArray&)>& take);

/// The bytes of one vertex in all of these arrays.
[[nodiscard]] std::size_t bytes_of_a_vertex(const GlbContents& contents, bool is_quantized);

}  // namespace scanknit
