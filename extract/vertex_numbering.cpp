#include "extract/vertex_numbering.h"

#include <algorithm>
#include <bit>

#include "core/check.h"

namespace scanknit {
namespace {

constexpr std::uint16_t edge_slot(int axis, int x, int y, int z) {
  return static_cast<std::uint16_t>(((axis * kBlockCells + x) * kBlockCells + y) * kBlockCells + z);
}

}  // namespace

void BlockRecord::set_edges(const BlockTopology& topology) {
  vertices = topology.vertices();
  edge_vertices = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t x = 0; x < kBlockCells; ++x) {
      rank[axis][x] = static_cast<std::uint16_t>(edge_vertices);
      edge_vertices += static_cast<std::uint32_t>(std::popcount(vertices[axis][x]));
      for (std::uint64_t bits = topology.pinched()[axis][x]; bits != 0; bits &= bits - 1) {
        const int bit = std::countr_zero(bits);
        pinched.push_back(edge_slot(static_cast<int>(axis), static_cast<int>(x), bit / kBlockCells, bit % kBlockCells));
      }
    }
  }
}

std::size_t BlockRecord::index_of(int axis, int x, int y, int z, bool second_fan) const {
  if (second_fan && !pinched.empty()) {
    const std::uint16_t slot = edge_slot(axis, x, y, z);
    const auto found = std::lower_bound(pinched.begin(), pinched.end(), slot);
    if (found != pinched.end() && *found == slot)
      return first_vertex + edge_vertices + static_cast<std::size_t>(found - pinched.begin());
  }
  const auto a = static_cast<std::size_t>(axis);
  const auto word = static_cast<std::size_t>(x);
  const std::uint64_t before = (std::uint64_t{1} << (kBlockCells * y + z)) - 1;
  return first_vertex + rank[a][word] + static_cast<std::size_t>(std::popcount(vertices[a][word] & before));
}

MeshSize number_vertices(std::span<BlockRecord> records) {
  MeshSize size;
  for (BlockRecord& record : records) {
    record.first_vertex = size.vertices;
    record.first_triangle = size.triangles;
    size.vertices += record.vertex_count();
    size.triangles += record.triangles;
  }
  return size;
}

VertexNumbering::VertexNumbering(std::span<const Eigen::Vector3i> origins, std::span<const BlockRecord> records,
                                 std::size_t block) {
  records_[0] = &records[block];
  for (int neighbour = 1; neighbour < 8; ++neighbour) {
    const Eigen::Vector3i offset(neighbour & 1, (neighbour >> 1) & 1, neighbour >> 2);
    const Eigen::Vector3i origin = origins[block] + kBlockCells * offset;
    const auto found = std::lower_bound(origins.begin(), origins.end(), origin, is_before);
    if (found != origins.end() && *found == origin)
      records_[static_cast<std::size_t>(neighbour)] = &records[static_cast<std::size_t>(found - origins.begin())];
  }
}

std::size_t VertexNumbering::index_of(int x, int y, int z, int edge) const {
  const int low = edge_low_corner(edge);
  x += corner_coordinate(low, 0);
  y += corner_coordinate(low, 1);
  z += corner_coordinate(low, 2);
  const int neighbour = (x >> 3) | ((y >> 3) << 1) | ((z >> 3) << 2);  // 8 is the first voxel of the next block
  const BlockRecord* const owner = records_[static_cast<std::size_t>(neighbour)];
  SCANKNIT_CHECK(owner != nullptr);  // an active cell's corners are observed, and observed voxels lie in blocks
  return owner->index_of(edge_axis(edge), x & 7, y & 7, z & 7, is_second_fan(edge));
}

}  // namespace scanknit
