#include "extract/marching_cubes.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <vector>

#include "extract/block_topology.h"
#include "extract/face_decider.h"
#include "extract/smooth_normals.h"
#include "extract/triangulate_cell.h"
#include "extract/vertex_numbering.h"
#include "extract/vertex_sampler.h"

namespace scanknit {
namespace {

/// The ambiguous faces of the cell at (x, y, z) whose Highs are joined.
FaceMask joined_faces(const ValueBlock& values, int x, int y, int z, FaceMask ambiguous, double isovalue) {
  unsigned joined = 0;
  for (unsigned faces = ambiguous; faces != 0; faces &= faces - 1) {
    const auto face = static_cast<std::size_t>(std::countr_zero(faces));
    std::array<double, 4> value{};
    for (std::size_t i = 0; i < 4; ++i) {
      const int corner = kFaceCorners[face][i];
      value[i] = static_cast<double>(values.at(x + corner_coordinate(corner, 0), y + corner_coordinate(corner, 1),
                                               z + corner_coordinate(corner, 2))) -
                 isovalue;
    }
    if (decide_face(value) == FaceDecision::kHighsJoined) joined |= 1u << face;
  }
  return static_cast<FaceMask>(joined);
}

/// An active cell and how its faces are resolved.
struct ActiveCell {
  int x, y, z;
  CornerMask highs;
  FaceMask joined;
};

/// Calls visit(ActiveCell) for a block's active cells in order.
template <typename Visit>
void for_each_active_cell(const ValueBlock& values, const BlockTopology& topology, double isovalue,
                          const Visit& visit) {
  for (int x = 0; x < kBlockCells; ++x) {
    for (std::uint64_t bits = topology.active_cells()[static_cast<std::size_t>(x)]; bits != 0; bits &= bits - 1) {
      const int y = std::countr_zero(bits) / kBlockCells;
      const int z = std::countr_zero(bits) % kBlockCells;
      const CornerMask highs = topology.highs(x, y, z);
      visit(ActiveCell{x, y, z, highs, joined_faces(values, x, y, z, kAmbiguousFaces[highs], isovalue)});
    }
  }
}

/// Calls work(i) for each block, in parallel.
template <typename Work>
void for_each_block(std::size_t count, const Work& work) {
  constexpr std::size_t kGrain = 16;  // blocks; some hundred microseconds
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, kGrain), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) work(i);
  });
}

BlockRecord count_block(const ValueBlock& values, const ExtractConfig& config, CaseCounts& counts) {
  const BlockTopology topology(values, float_isovalue(config.isovalue));
  BlockRecord record;
  record.set_edges(topology);
  for_each_active_cell(values, topology, config.isovalue, [&](const ActiveCell& cell) {
    const CellTriangles triangles = triangulate_cell(cell.highs, cell.joined);
    record.triangles += static_cast<std::uint32_t>(triangles.size());
    record.interior_vertices += triangles.interior_contour().empty() ? 0 : 1;

    const auto ambiguous = static_cast<std::size_t>(std::popcount(kAmbiguousFaces[cell.highs]));
    const auto joined = static_cast<std::size_t>(std::popcount(cell.joined));
    ++counts.configuration[kCaseTable.configuration[cell.highs]];
    counts.ambiguous_faces_joined += joined;
    counts.ambiguous_faces_separated += ambiguous - joined;
  });
  counts.configuration[0] += topology.cells_without_surface();
  counts.skipped_cells += topology.skipped_cells();
  return record;
}

void add(CaseCounts& sum, const CaseCounts& part) {
  for (std::size_t i = 0; i < sum.configuration.size(); ++i) sum.configuration[i] += part.configuration[i];
  sum.ambiguous_faces_joined += part.ambiguous_faces_joined;
  sum.ambiguous_faces_separated += part.ambiguous_faces_separated;
  sum.skipped_cells += part.skipped_cells;
}

std::vector<BlockRecord> count_blocks(const BlockSource& source, const ExtractConfig& config, CaseCounts& counts) {
  std::vector<BlockRecord> records(source.origins().size());
  tbb::enumerable_thread_specific<CaseCounts> parts;  // sums of integers: their order does not matter
  for_each_block(records.size(), [&](std::size_t i) {
    ValueBlock values;
    source.load_values(i, values);
    records[i] = count_block(values, config, parts.local());
  });
  for (const CaseCounts& part : parts) add(counts, part);
  return records;
}

/// Writes one block's part of the mesh into its places.
class BlockWriter {
 public:
  BlockWriter(const BlockRecord& record, const VertexNumbering& numbering, const VertexSampler& sampler,
              bool inside_is_high, Mesh& mesh)
      : record_(record), numbering_(numbering), sampler_(sampler), inside_is_high_(inside_is_high), mesh_(mesh) {
    next_interior_vertex_ = record.first_interior_vertex();
    next_triangle_ = record.first_triangle;
  }

  void write_edge_vertices() {
    std::size_t index = record_.first_vertex;
    for (int axis = 0; axis < 3; ++axis) {
      for (int x = 0; x < kBlockCells; ++x) {
        std::uint64_t bits = record_.vertices[static_cast<std::size_t>(axis)][static_cast<std::size_t>(x)];
        for (; bits != 0; bits &= bits - 1) {
          const int bit = std::countr_zero(bits);
          write_vertex(index++, sampler_.on_edge({{x, bit / kBlockCells, bit % kBlockCells}, axis}));
        }
      }
    }
    for (const std::uint16_t slot : record_.pinched) {
      const Eigen::Vector3i low((slot >> 6) & 7, (slot >> 3) & 7, slot & 7);
      write_vertex(index++, sampler_.on_edge({low, slot >> 9}));
    }
  }

  void write_cell(const ActiveCell& cell) {
    const CellTriangles triangles = triangulate_cell(cell.highs, cell.joined);
    std::array<std::uint32_t, kEdges + 1> vertex{};
    for (int edge = 0; edge < kEdges; ++edge) {
      if (is_crossed(cell.highs, edge))
        vertex[static_cast<std::size_t>(edge)] =
            static_cast<std::uint32_t>(numbering_.index_of(cell.x, cell.y, cell.z, edge));
    }
    if (const auto contour = triangles.interior_contour(); !contour.empty()) {
      vertex[kFirstInteriorVertex] = static_cast<std::uint32_t>(next_interior_vertex_);
      write_vertex(next_interior_vertex_++, sampler_.inside_cell({cell.x, cell.y, cell.z}, contour));
    }
    for (const CellTriangle& t : triangles) {  // counter-clockwise seen from the Lows
      mesh_.triangles[next_triangle_++] = inside_is_high_ ? Triangle{vertex[t[0]], vertex[t[1]], vertex[t[2]]}
                                                          : Triangle{vertex[t[0]], vertex[t[2]], vertex[t[1]]};
    }
  }

 private:
  void write_vertex(std::size_t index, const SurfaceVertex& vertex) {
    mesh_.positions_m[index] = vertex.p_world.cast<float>();
    if (!mesh_.normals.empty()) mesh_.normals[index] = vertex.outward.cast<float>();
    if (mesh_.colours.empty()) return;
    const auto byte = [](double channel) {
      return static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(channel, 0.0, 1.0)));
    };
    mesh_.colours[index] = {byte(vertex.colour.x()), byte(vertex.colour.y()), byte(vertex.colour.z())};
  }

  const BlockRecord& record_;
  const VertexNumbering& numbering_;
  const VertexSampler& sampler_;
  bool inside_is_high_;
  Mesh& mesh_;
  std::size_t next_interior_vertex_;
  std::size_t next_triangle_;
};

void write_blocks(const BlockSource& source, const ExtractConfig& config, std::span<const BlockRecord> records,
                  bool inside_is_high, Mesh& mesh) {
  const VertexSampler::Frame frame{source.voxel_size_m(), source.translation_m(), inside_is_high};
  for_each_block(records.size(), [&](std::size_t i) {
    if (records[i].vertex_count() == 0 && records[i].triangles == 0) return;
    ValueBlock values;
    source.load_values(i, values);
    std::optional<ColourBlock> colours;
    if (source.has_colours()) source.load_colours(i, colours.emplace());

    const VertexNumbering numbering(source.origins(), records, i);
    const VertexSampler sampler(values, colours ? &*colours : nullptr, source.origins()[i], frame, config);
    BlockWriter writer(records[i], numbering, sampler, inside_is_high, mesh);
    writer.write_edge_vertices();
    const BlockTopology topology(values, float_isovalue(config.isovalue));
    for_each_active_cell(values, topology, config.isovalue, [&](const ActiveCell& cell) { writer.write_cell(cell); });
  });
}

}  // namespace

Result<Surface> march_cubes(const BlockSource& source, const ExtractConfig& config, bool inside_is_high) {
  Surface surface;
  std::vector<BlockRecord> records = count_blocks(source, config, surface.cases);
  const MeshSize size = number_vertices(records);
  constexpr std::size_t kMaxVertices = 0xFFFFFFFEu;
  if (size.vertices > kMaxVertices)
    return Error{ErrorCode::kMesh, "the mesh would have more than 2^32 - 2 vertices; use larger voxels", "extract"};

  Mesh& mesh = surface.mesh;
  mesh.positions_m.resize(size.vertices);
  mesh.triangles.resize(size.triangles);
  if (config.normals) mesh.normals.resize(size.vertices);
  if (source.has_colours()) mesh.colours.resize(size.vertices);
  write_blocks(source, config, records, inside_is_high, mesh);
  if (config.normals) fill_missing_normals(mesh);
  return surface;
}

}  // namespace scanknit
