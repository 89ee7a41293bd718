#include "extract/marching_cubes.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <optional>

#include "core/check.h"
#include "extract/prefault.h"
#include "extract/resolve_cell.h"

namespace scanknit {
namespace {

/// Blocks that one task takes: enough that the walk over neighbours pays, few enough to balance.
constexpr std::size_t kBlocksPerTask = 128;

/// Calls work(task, range) for each run of kBlocksPerTask blocks, in parallel.
template <typename Work>
void for_each_task(BlockRange blocks, const Work& work) {
  const std::size_t tasks = (blocks.size() + kBlocksPerTask - 1) / kBlocksPerTask;
  tbb::parallel_for(std::size_t{0}, tasks, [&](std::size_t task) {
    const std::size_t begin = blocks.begin + task * kBlocksPerTask;
    work(task, BlockRange{begin, std::min(blocks.end, begin + kBlocksPerTask)});
  });
}

/// The triangles of the cases that need no values, as places in VertexIds.
class PlacedCases {
 public:
  static constexpr std::size_t kMaxTriangles = 4;
  struct Case {
    std::array<std::uint16_t, 3 * kMaxTriangles> places{};  ///< beyond `triangles` the first triangle again
    std::uint8_t triangles = 0;
  };

  [[nodiscard]] static const PlacedCases& get(bool turns_triangles) {
    static const std::array<PlacedCases, 2> cases = {PlacedCases(false), PlacedCases(true)};
    return cases[turns_triangles ? 1 : 0];
  }
  [[nodiscard]] const Case& operator[](CornerMask highs) const { return cases_[highs]; }

 private:
  explicit PlacedCases(bool turns_triangles) {
    for (std::size_t highs = 0; highs < cases_.size(); ++highs) {
      const auto& simple = CellTable::get().simple(static_cast<CornerMask>(highs));
      const auto triangles = CellTable::get().triangles(simple);
      if (simple.needs_values || triangles.empty()) continue;
      SCANKNIT_CHECK(triangles.size() <= kMaxTriangles);
      Case& placed = cases_[highs];
      placed.triangles = static_cast<std::uint8_t>(triangles.size());
      for (std::size_t i = 0; i < placed.places.size(); ++i) {
        const CellTriangle& triangle = triangles[i / 3 < triangles.size() ? i / 3 : 0];
        const std::size_t corner = turns_triangles ? (3 - i % 3) % 3 : i % 3;
        placed.places[i] = static_cast<std::uint16_t>(kEdgePlace[triangle[corner]]);
      }
    }
  }

  std::array<Case, 256> cases_{};
};

/// Writes one block's part of the mesh into its places.
class BlockWriter {
 public:
  BlockWriter(const BlockRecord& record, const BlockRecord& first, const VertexIds& ids, const VertexSampler& sampler,
              bool turns_triangles, Mesh& mesh)
      : record_(record),
        ids_(ids),
        sampler_(sampler),
        table_(CellTable::get()),
        placed_cases_(PlacedCases::get(turns_triangles)),
        mesh_(mesh),
        next_vertex_(record.first_vertex - first.first_vertex),
        next_interior_vertex_(static_cast<std::uint32_t>(record.first_interior_vertex())),
        vertices_before_(first.first_vertex),
        second_(turns_triangles ? 2 : 1),
        third_(3 - second_),
        next_triangle_(mesh.triangles.data() + (record.first_triangle - first.first_triangle)),
        end_(next_triangle_ + record.triangles) {}

  void write_edge_vertices() {
    const bool is_bare = mesh_.normals.empty() && mesh_.colours.empty();
    for (int axis = 0; axis < 3; ++axis) {
      const VoxelBits& edges = record_.vertices[static_cast<std::size_t>(axis)];
      if (is_bare) {
        next_vertex_ += sampler_.write_positions(axis, edges, mesh_.positions_m.data() + next_vertex_);
        continue;
      }
      for (int x = 0; x < kBlockCells; ++x) {
        for (std::uint64_t bits = edges[static_cast<std::size_t>(x)]; bits != 0; bits &= bits - 1) {
          const int bit = std::countr_zero(bits);
          write_vertex(next_vertex_++, sampler_.on_edge({{x, bit / kBlockCells, bit % kBlockCells}, axis}));
        }
      }
    }
    for (const std::uint16_t slot : record_.pinched)
      write_vertex(next_vertex_++, sampler_.on_edge({{(slot >> 6) & 7, (slot >> 3) & 7, slot & 7}, slot >> 9}));
  }

  /// A cell that the signs of its corners decide.
  void write_simple(int x, int y, int z, CornerMask highs) {
    constexpr std::size_t kMax = PlacedCases::kMaxTriangles;
    if (ids_.has_pinched() || end_ - next_triangle_ < static_cast<std::ptrdiff_t>(kMax))
      return write_triangles(x, y, z, table_.triangles(table_.simple(highs)));
    // As many for each cell: the next one writes over those too many. A loop that ends where nobody can foresee it
    // would cost more.
    const std::uint32_t* const ids = ids_.of_cell(x, y, z);
    const PlacedCases::Case& placed = placed_cases_[highs];
    const auto id = [&](std::size_t i) { return ids[placed.places[i]]; };
    for (std::size_t i = 0; i < kMax; ++i) next_triangle_[i] = {id(3 * i), id(3 * i + 1), id(3 * i + 2)};
    next_triangle_ += placed.triangles;
  }

  void write_resolved(int x, int y, int z, CellEntry entry) {
    const auto interior = table_.interior_vertices(entry);
    if (interior.empty()) return write_triangles(x, y, z, table_.triangles(entry));
    const std::uint32_t first_interior = next_interior_vertex_;
    for (const EdgeMask edges : interior)
      write_vertex(next_interior_vertex_++ - vertices_before_, sampler_.inside_cell({x, y, z}, edges));
    for (const CellTriangle& t : table_.triangles(entry)) {
      const auto id = [&](EdgeIndex vertex) {
        return vertex < kFirstInteriorVertex ? ids_.of(x, y, z, vertex)
                                             : first_interior + vertex - kFirstInteriorVertex;
      };
      *next_triangle_++ = {id(t[0]), id(t[second_]), id(t[third_])};
    }
  }

 private:
  void write_triangles(int x, int y, int z, std::span<const CellTriangle> triangles) {
    const auto id = [&](EdgeIndex edge) { return ids_.of(x, y, z, edge); };
    for (const CellTriangle& t : triangles) *next_triangle_++ = {id(t[0]), id(t[second_]), id(t[third_])};
  }

  void write_vertex(std::size_t place, const SurfaceVertex& vertex) {
    mesh_.positions_m[place] = vertex.p_world.cast<float>();
    if (!mesh_.normals.empty()) mesh_.normals[place] = vertex.outward.cast<float>();
    if (!mesh_.colours.empty()) mesh_.colours[place] = vertex.rgb();
  }

  const BlockRecord& record_;
  const VertexIds& ids_;
  const VertexSampler& sampler_;
  const CellTable& table_;
  const PlacedCases& placed_cases_;
  Mesh& mesh_;
  std::size_t next_vertex_;
  std::uint32_t next_interior_vertex_;
  std::size_t vertices_before_;
  std::size_t second_, third_;  ///< of a triangle's corners as the table has them
  Triangle* next_triangle_;
  Triangle* end_;
};

}  // namespace

// Counter-clockwise seen from the Lows is right when the Highs are matter; a mirror turns that round.
Error too_many_vertices() {
  return {ErrorCode::kMesh, "the mesh would have more than 2^32 - 2 vertices; use larger voxels", "extract"};
}

MarchingCubes::MarchingCubes(const BlockSource& source, const ExtractConfig& config, bool is_inside_high)
    : source_(source),
      config_(config),
      turns_triangles_(is_inside_high == is_mirrored(source)),
      frame_(source.T_world_index(), is_inside_high),
      signs_(source, config.isovalue),
      record_of_(signs_.size(), nullptr) {}

void MarchingCubes::count(BlockRange blocks, CaseHistogram& histogram) {
  const std::size_t first_list = records_.size();
  records_.resize(first_list + (blocks.size() + kBlocksPerTask - 1) / kBlocksPerTask);
  tbb::enumerable_thread_specific<CaseHistogram> parts;  // sums of integers: their order does not matter
  for_each_task(blocks, [&](std::size_t task, BlockRange range) {
    NeighbourWalk walk(source_.origins());
    CaseHistogram& part = parts.local();
    std::vector<BlockRecord>& records = records_[first_list + task];
    for (std::size_t block = range.begin; block < range.end; ++block) {
      const Neighbours& neighbours = walk.of(block);
      if (signs_.is_plain(neighbours)) {
        part.add_without_surface(std::size_t{kBlockCells} * kBlockCells * kBlockCells);
        continue;
      }
      BlockRecord record = count_block(block, neighbours, part);
      if (record.vertex_count() > 0 || record.triangles > 0) records.push_back(std::move(record));
    }
    for (const BlockRecord& record : records) record_of_[record.block] = &record;
  });
  for (const CaseHistogram& part : parts) histogram.add(part);
}

BlockRecord MarchingCubes::count_block(std::size_t block, const Neighbours& neighbours,
                                       CaseHistogram& histogram) const {
  const CellTable& table = CellTable::get();
  const BlockTopology topology(signs_, neighbours);
  BlockRecord record;
  record.block = block;
  record.set_edges(topology);
  std::uint32_t triangles = 0;
  std::optional<ValueBlock> values;  // few blocks of a smooth surface need them
  topology.for_each_active_cell([&](int x, int y, int z, CornerMask highs) {
    const CellTable::Simple& simple = table.simple(highs);
    if (!simple.needs_values) {
      triangles += simple.triangle_count;
      return histogram.add_simple(highs);
    }
    if (!values) source_.load_values(block, values.emplace());
    const CellEntry entry = resolve_cell(*values, x, y, z, highs, config_.isovalue, config_.decider);
    record.resolved.push_back(entry);
    triangles += table.triangle_count(entry);
    record.interior_vertices += table.interior_count(entry);
    histogram.add(entry);
  });
  record.triangles = triangles;
  histogram.add_without_surface(topology.cells_without_surface());
  histogram.add_skipped(topology.skipped_cells());
  return record;
}

void MarchingCubes::number(std::size_t first_vertex) {
  std::size_t first_triangle = 0;
  for (auto& list : records_) {
    for (BlockRecord& record : list) {
      record.first_vertex = first_vertex;
      record.first_triangle = first_triangle;
      first_vertex += record.vertex_count();
      first_triangle += record.triangles;
    }
  }
}

MeshSize MarchingCubes::size_of(BlockRange blocks) const {
  MeshSize size;
  for (std::size_t block = blocks.begin; block < blocks.end; ++block) {
    if (record_of_[block] == nullptr) continue;
    size.vertices += record_of_[block]->vertex_count();
    size.triangles += record_of_[block]->triangles;
  }
  return size;
}

void MarchingCubes::write(BlockRange blocks, Mesh& mesh) const {
  const MeshSize size = size_of(blocks);
  mesh.positions_m.resize(size.vertices);
  mesh.triangles.resize(size.triangles);
  mesh.normals.resize(config_.normals ? size.vertices : 0);
  mesh.colours.resize(source_.has_colours() ? size.vertices : 0);
  if (size.vertices == 0 && size.triangles == 0) return;
  const auto first = std::find_if(record_of_.begin() + static_cast<std::ptrdiff_t>(blocks.begin), record_of_.end(),
                                  [](const BlockRecord* record) { return record != nullptr; });
  for_each_task(blocks, [&](std::size_t, BlockRange range) {
    prefault_part(range, **first, mesh);
    NeighbourWalk walk(source_.origins());
    for (std::size_t block = range.begin; block < range.end; ++block) {
      if (record_of_[block] != nullptr) write_block(*record_of_[block], walk.of(block), **first, mesh);
    }
  });
}

/// Memory is fresh from the system when the arrays are large.
void MarchingCubes::prefault_part(BlockRange blocks, const BlockRecord& first, Mesh& mesh) const {
  const MeshSize size = size_of(blocks);
  for (std::size_t block = blocks.begin; block < blocks.end; ++block) {
    const BlockRecord* const record = record_of_[block];
    if (record == nullptr) continue;
    prefault(mesh.positions_m.data() + (record->first_vertex - first.first_vertex),
             size.vertices * sizeof(Eigen::Vector3f));
    prefault(mesh.triangles.data() + (record->first_triangle - first.first_triangle),
             size.triangles * sizeof(Triangle));
    return;
  }
}

void MarchingCubes::write_block(const BlockRecord& record, const Neighbours& neighbours, const BlockRecord& first,
                                Mesh& mesh) const {
  VertexIds::Records records{};
  for (int upper = 0; upper < 8; ++upper) {
    const std::size_t block = neighbours.at(upper & 1, (upper >> 1) & 1, upper >> 2);
    if (block != kNoBlock) records[static_cast<std::size_t>(upper)] = record_of_[block];
  }
  const VertexIds ids(records);
  ValueBlock values;
  source_.load_values(record.block, values);
  values.keep(!config_.normals);
  std::optional<ColourBlock> colours;
  if (source_.has_colours()) source_.load_colours(record.block, colours.emplace());
  const VertexSampler sampler(values, colours ? &*colours : nullptr, source_.origins()[record.block], frame_, config_);

  BlockWriter writer(record, first, ids, sampler, turns_triangles_, mesh);
  writer.write_edge_vertices();
  const CellTable& table = CellTable::get();
  auto resolved = record.resolved.begin();
  const BlockTopology topology(signs_, neighbours);
  topology.for_each_active_cell([&](int x, int y, int z, CornerMask highs) {
    if (table.simple(highs).needs_values) {
      writer.write_resolved(x, y, z, *resolved++);
    } else {
      writer.write_simple(x, y, z, highs);
    }
  });
}

}  // namespace scanknit
