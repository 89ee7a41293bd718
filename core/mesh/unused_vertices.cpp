#include "core/mesh/unused_vertices.h"

#include <cstdint>
#include <limits>
#include <vector>

namespace scanknit {

void drop_unused_vertices(Mesh& mesh) {
  constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> new_index(mesh.positions_m.size(), kUnused);
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t v : t) new_index[v] = 0;
  }
  std::uint32_t next = 0;
  for (std::uint32_t v = 0; v < new_index.size(); ++v) {
    if (new_index[v] == kUnused) continue;
    mesh.positions_m[next] = mesh.positions_m[v];
    if (!mesh.normals.empty()) mesh.normals[next] = mesh.normals[v];
    if (!mesh.colours.empty()) mesh.colours[next] = mesh.colours[v];
    new_index[v] = next++;
  }
  mesh.positions_m.resize(next);
  if (!mesh.normals.empty()) mesh.normals.resize(next);
  if (!mesh.colours.empty()) mesh.colours.resize(next);
  for (Triangle& t : mesh.triangles) {
    for (std::uint32_t& v : t) v = new_index[v];
  }
}

void return_unused_memory(Mesh& mesh) {
  const auto shrink = [](auto& array) {
    if (array.size() < array.capacity() / 8 * 7) array.shrink_to_fit();  // takes both, for a moment
  };
  shrink(mesh.positions_m);
  shrink(mesh.normals);
  shrink(mesh.colours);
  shrink(mesh.triangles);
}

}  // namespace scanknit
