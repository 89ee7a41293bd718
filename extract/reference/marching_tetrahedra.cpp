#include "extract/reference/marching_tetrahedra.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <utility>

#include "extract/smooth_normals.h"
#include "extract/split_pinches.h"

namespace scanknit {
namespace {

/// An edge of a tetrahedron, in half index coordinates: its first end in lexicographic order, and the way to the other.
struct TetraEdge {
  std::array<std::int64_t, 3> low{};
  std::array<std::int8_t, 3> step{};
  bool operator==(const TetraEdge&) const = default;
};

/// Whether the edge lies in a plane between blocks.
[[nodiscard]] bool is_between_blocks(const TetraEdge& edge) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (edge.step[i] == 0 && edge.low[i] % (std::int64_t{2} * kBlockCells) == 0) return true;
  }
  return false;
}

struct TetraEdgeHash {
  std::size_t operator()(const TetraEdge& edge) const {
    constexpr std::uint64_t kRow = 0x9E3779B97F4A7C15u;  // 2^64 / the golden ratio: spreads rows evenly
    std::uint64_t hash = 0;
    for (const std::int64_t number : edge.low) hash = hash * kRow + static_cast<std::uint64_t>(number);
    for (const std::int8_t number : edge.step) hash = hash * 5 + static_cast<std::uint64_t>(number + 2);
    return hash;
  }
};

using PointValues = std::array<double, kCellPoints>;

[[nodiscard]] TetraEdge tetra_edge(const Eigen::Vector3i& cell, int a, int b) {
  TetraEdge edge;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    edge.low[i] = 2 * std::int64_t{cell[axis]} + half_coordinate(a, axis);
    edge.step[i] = static_cast<std::int8_t>(half_coordinate(b, axis) - half_coordinate(a, axis));
  }
  return edge;
}

/// Whether `a` comes before `b` in every cell that has both.
[[nodiscard]] bool is_lower(int a, int b) {
  for (int axis = 0; axis < 3; ++axis) {
    const int difference = half_coordinate(b, axis) - half_coordinate(a, axis);
    if (difference != 0) return difference > 0;
  }
  return false;
}

/// Fills in the face points and the centre. Both cells at a face add its corners in the same order, bit for bit. Sums
/// of equal floats are exact in a double, and rounding is monotone: corners of one colour have means of that colour.
void add_means(PointValues& value) {
  for (std::size_t point = kFirstFacePoint; point < kCellPoints; ++point) {
    const CornerMask corners = kCornersOfPoint[point];
    value[point] = 0;
    for (int corner = 0; corner < kCorners; ++corner) {
      if (is_high(corners, corner)) value[point] += value[static_cast<std::size_t>(corner)];
    }
    value[point] /= std::popcount(corners);
  }
}

class TetraMarcher {
 public:
  TetraMarcher(const Eigen::Affine3d& T_world_index, TetraSplit split, double isovalue, VertexPlacement placement,
               bool inside_is_high)
      : T_world_index_(T_world_index),
        shortest_side_(T_world_index.linear().colwise().norm().minCoeff()),
        split_(split),
        isovalue_(isovalue),
        placement_(placement),
        is_flipped_(inside_is_high == (T_world_index.linear().determinant() < 0)) {}

  void march_block(const ValueBlock& values, const Eigen::Vector3i& origin) {
    in_block_.clear();
    for (int x = 0; x < kBlockCells; ++x) {
      for (int y = 0; y < kBlockCells; ++y) {
        for (int z = 0; z < kBlockCells; ++z) march_cell(values, {x, y, z}, origin);
      }
    }
  }

  /// Leaves the marcher empty.
  [[nodiscard]] Mesh take_mesh() {
    between_blocks_.clear();
    return std::exchange(mesh_, {});
  }
  [[nodiscard]] const Mesh& mesh() const { return mesh_; }

 private:
  void march_cell(const ValueBlock& values, const Eigen::Vector3i& in_block, const Eigen::Vector3i& origin) {
    PointValues value{};
    int highs = 0;
    for (int corner = 0; corner < kCorners; ++corner) {
      const Eigen::Vector3i offset(corner_coordinate(corner, 0), corner_coordinate(corner, 1),
                                   corner_coordinate(corner, 2));
      const float sample = values.at(in_block + offset);
      if (!is_observed(sample)) return;
      value[static_cast<std::size_t>(corner)] = static_cast<double>(sample);
      highs += static_cast<double>(sample) >= isovalue_ ? 1 : 0;
    }
    if (highs == 0 || highs == kCorners) return;
    if (cell_points(split_) > kCorners) add_means(value);

    const Eigen::Vector3i cell = origin + in_block;
    const auto parity = static_cast<std::size_t>((cell.x() ^ cell.y() ^ cell.z()) & 1);
    for (const Tetra& tetra : tetrahedra(split_, parity)) march_tetra(cell, value, tetra);
  }

  void march_tetra(const Eigen::Vector3i& cell, const PointValues& value, const Tetra& tetra) {
    std::size_t highs = 0;
    for (std::size_t i = 0; i < 4; ++i) highs |= static_cast<std::size_t>(value[tetra[i]] >= isovalue_) << i;
    const TetraPolygon& polygon = kTetraPolygons[highs];
    std::array<std::uint32_t, 4> vertex{};
    for (std::size_t i = 0; i < polygon.size; ++i)
      vertex[i] = vertex_between(cell, value, tetra[polygon.edges[i][0]], tetra[polygon.edges[i][1]]);
    for (std::size_t i = 2; i < polygon.size; ++i) {  // counter-clockwise seen from the Lows
      mesh_.triangles.push_back(is_flipped_ ? Triangle{vertex[0], vertex[i], vertex[i - 1]}
                                            : Triangle{vertex[0], vertex[i - 1], vertex[i]});
    }
  }

  [[nodiscard]] std::uint32_t vertex_between(const Eigen::Vector3i& cell, const PointValues& value, CellPoint a,
                                             CellPoint b) {
    if (!is_lower(a, b)) std::swap(a, b);
    const TetraEdge edge = tetra_edge(cell, a, b);
    VertexMap& vertices = is_between_blocks(edge) ? between_blocks_ : in_block_;
    const auto [known, is_new] = vertices.try_emplace(edge, static_cast<std::uint32_t>(mesh_.positions_m.size()));
    if (is_new) mesh_.positions_m.push_back(p_world(edge, value[a] - isovalue_, value[b] - isovalue_).cast<float>());
    return known->second;
  }

  /// The zero of the linear interpolant between two values of different sign. Like VertexSampler, it keeps a distance
  /// from the ends, 1/1024 of the edge or some roundings of a float there where that is more: edges that leave a
  /// point side by side are apart by at least half a cell's side at their ends, so the distance counts in such sides.
  [[nodiscard]] Eigen::Vector3d p_world(const TetraEdge& edge, double at_low, double at_high) const {
    const auto half = [](const auto& p) {
      return Eigen::Vector3d(0.5 * static_cast<double>(p[0]), 0.5 * static_cast<double>(p[1]),
                             0.5 * static_cast<double>(p[2]));
    };
    const Eigen::Vector3d low = T_world_index_ * half(edge.low);
    const Eigen::Vector3d step = T_world_index_.linear() * half(edge.step);
    if (placement_ == VertexPlacement::kMidEdge) return low + 0.5 * step;
    const double reach = std::max(low.cwiseAbs().maxCoeff(), (low + step).cwiseAbs().maxCoeff());
    const double margin = std::clamp(reach / shortest_side_ * 0x1p-20, 0x1p-10, 0.25);
    const double t = at_low / (at_low - at_high);  // one is < 0, the other >= 0: never 0 / 0
    return low + std::clamp(t, margin, 1 - margin) * step;
  }

  Eigen::Affine3d T_world_index_;
  double shortest_side_;  // of a cell, metres
  TetraSplit split_;
  double isovalue_;
  VertexPlacement placement_;
  bool is_flipped_;
  Mesh mesh_;
  using VertexMap = std::unordered_map<TetraEdge, std::uint32_t, TetraEdgeHash>;
  VertexMap in_block_;        // of the current block only: small, so that it stays in the cache
  VertexMap between_blocks_;  // of all blocks
};

[[nodiscard]] bool has_too_many_vertices(const Mesh& mesh) {
  return mesh.positions_m.size() > 0xFFFFFFFEu;
}

Error too_many_vertices() {
  return {ErrorCode::kMesh, "the mesh would have more than 2^32 - 2 vertices; use larger voxels", "extract"};
}

}  // namespace

Result<Mesh> march_tetrahedra(const BlockSource& source, TetraSplit split, double isovalue, VertexPlacement placement,
                              bool inside_is_high, bool normals) {
  TetraMarcher marcher(source.T_world_index(), split, isovalue, placement, inside_is_high);
  ValueBlock values;
  for (std::size_t block = 0; block < source.origins().size(); ++block) {
    source.load_values(block, values);
    marcher.march_block(values, source.origins()[block]);
    if (has_too_many_vertices(marcher.mesh())) return too_many_vertices();
  }
  Mesh mesh = marcher.take_mesh();
  split_pinched_vertices(mesh);
  if (has_too_many_vertices(mesh)) return too_many_vertices();
  if (normals) {
    mesh.normals.assign(mesh.positions_m.size(), Eigen::Vector3f::Zero());
    fill_missing_normals(mesh);
  }
  return mesh;
}

}  // namespace scanknit
