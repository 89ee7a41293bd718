#include "export/glb/glb_compression.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <cstring>

namespace scanknit {
namespace {

std::vector<unsigned char> compressed_indices(const GlbArray& array) {
  std::vector<unsigned int> indices(array.count);
  std::memcpy(indices.data(), array.bytes.data(), array.bytes.size());
  const auto vertices = static_cast<std::size_t>(*std::max_element(indices.begin(), indices.end())) + 1;
  std::vector<unsigned char> packed(meshopt_encodeIndexBufferBound(indices.size(), vertices));
  meshopt_encodeIndexVersion(1);  // the one that EXT_meshopt_compression names
  packed.resize(meshopt_encodeIndexBuffer(packed.data(), packed.size(), indices.data(), indices.size()));
  return packed;
}

std::vector<unsigned char> compressed_vertices(const GlbArray& array) {
  std::vector<unsigned char> packed(meshopt_encodeVertexBufferBound(array.count, array.stride));
  meshopt_encodeVertexVersion(0);  // likewise
  packed.resize(
      meshopt_encodeVertexBuffer(packed.data(), packed.size(), array.bytes.data(), array.count, array.stride));
  return packed;
}

}  // namespace

MeshPart in_order_of_use(const GlbPart& part) {
  const std::size_t vertices = part.vertices.size();
  std::vector<unsigned int> indices;
  indices.reserve(3 * part.triangles.size());
  for (const Triangle& t : part.triangles) indices.insert(indices.end(), t.begin(), t.end());
  std::vector<unsigned int> sorted(indices.size()), place(vertices);
  meshopt_optimizeVertexCache(sorted.data(), indices.data(), indices.size(), vertices);
  auto used =
      static_cast<unsigned int>(meshopt_optimizeVertexFetchRemap(place.data(), sorted.data(), sorted.size(), vertices));

  MeshPart ordered{std::vector<std::uint32_t>(vertices), {}};
  for (std::size_t i = 0; i < vertices; ++i) {
    if (place[i] == ~0u) place[i] = used++;  // of no triangle
    ordered.vertices[place[i]] = part.vertices[i];
  }
  ordered.triangles.reserve(part.triangles.size());
  for (std::size_t i = 0; i < sorted.size(); i += 3) {
    ordered.triangles.emplace_back(place[sorted[i]], place[sorted[i + 1]], place[sorted[i + 2]]);
  }
  return ordered;
}

std::vector<unsigned char> compressed(const GlbArray& array) {
  return array.is_indices() ? compressed_indices(array) : compressed_vertices(array);
}

}  // namespace scanknit
