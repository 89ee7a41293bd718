#include "extract/incremental_mesher.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <exception>
#include <iterator>
#include <limits>
#include <new>
#include <optional>
#include <utility>

#include "core/check.h"
#include "extract/blocks/block_topology.h"
#include "extract/blocks/neighbours.h"
#include "extract/cell/cell_table.h"
#include "extract/extract_surface.h"
#include "extract/marching_cubes.h"
#include "extract/resolve_cell.h"
#include "extract/smooth_normals.h"
#include "extract/vertex_numbering.h"
#include "extract/vertex_sampler.h"

namespace scanknit {
namespace {

using Origins = std::vector<Eigen::Vector3i>;

/// Leaves that one task takes.
constexpr std::size_t kLeavesPerTask = 16;

Error update_error(const char* message) {
  return {ErrorCode::kConfig, message, "volume"};
}

bool is_at_the_end(const Eigen::Vector3i& origin) {
  constexpr int kReach = 2 * kBlockCells;  // neighbours of neighbours begin, and those of neighbours end, within an int
  return origin.minCoeff() < std::numeric_limits<int>::min() + kReach ||
         origin.maxCoeff() > std::numeric_limits<int>::max() - kReach;
}

/// All lists are sorted by is_before and hold nothing twice. A shift keeps the order.
Origins with_shifted(const Origins& leaves, const Origins& original, const Eigen::Vector3i& shift) {
  Origins moved(original);
  for (Eigen::Vector3i& leaf : moved) leaf += shift;
  Origins all;
  all.reserve(leaves.size() + moved.size());
  std::set_union(leaves.begin(), leaves.end(), moved.begin(), moved.end(), std::back_inserter(all), is_before);
  return all;
}

enum class Around { kAll, kLower };

/// The leaves, and all their 26 neighbours or the 7 towards -x, -y, -z; one axis after the other, so in linear time.
Origins dilated(Origins leaves, Around around) {
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3i step = kBlockCells * Eigen::Vector3i::Unit(axis);
    const Origins original = leaves;
    leaves = with_shifted(leaves, original, -step);
    if (around == Around::kAll) leaves = with_shifted(leaves, original, step);
  }
  return leaves;
}

void clear(Mesh& mesh) {
  mesh.positions_m.clear();
  mesh.normals.clear();
  mesh.colours.clear();
  mesh.triangles.clear();
}

bool is_same(const Mesh& a, const Mesh& b) {
  return a.triangles == b.triangles && a.positions_m == b.positions_m && a.normals == b.normals &&
         a.colours == b.colours;
}

/// Writes the cells of one leaf; vertices are numbered as cells come to use them.
class PatchWriter {
 public:
  PatchWriter(const BlockTopology& topology, const VertexSampler& sampler, bool has_normals, bool has_colours,
              Mesh& mesh)
      : topology_(topology), sampler_(sampler), has_normals_(has_normals), has_colours_(has_colours), mesh_(mesh) {
    ids_.fill(kNone);
  }

  void write_cell(const Eigen::Vector3i& cell, CellEntry entry, bool turns_triangles) {
    const CellTable& table = CellTable::get();
    const auto first_interior = static_cast<std::uint32_t>(mesh_.positions_m.size());
    for (const EdgeMask edges : table.interior_vertices(entry)) add_vertex(sampler_.inside_cell(cell, edges));
    const auto id = [&](EdgeIndex vertex) {
      return vertex < kFirstInteriorVertex ? id_on_edge(cell, vertex) : first_interior + vertex - kFirstInteriorVertex;
    };
    const std::size_t second = turns_triangles ? 2 : 1;
    for (const CellTriangle& t : table.triangles(entry))
      mesh_.triangles.push_back({id(t[0]), id(t[second]), id(t[3 - second])});
  }

 private:
  static constexpr std::size_t kPlaces = std::size_t{3} * kClosureSide * kClosureSide * kClosureSide;
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  [[nodiscard]] std::uint32_t id_on_edge(const Eigen::Vector3i& cell, EdgeIndex vertex) {
    const GridEdge edge = grid_edge(cell, vertex);
    auto place = static_cast<std::size_t>(closure_place(edge.axis, edge.low.x(), edge.low.y(), edge.low.z()));
    if (is_second_fan(vertex) && is_pinched(edge)) place += kPlaces;
    if (ids_[place] == kNone) {
      ids_[place] = static_cast<std::uint32_t>(mesh_.positions_m.size());
      add_vertex(sampler_.on_edge(edge));
    }
    return ids_[place];
  }

  /// Edges in the leaf's upper faces belong to other leaves: of the cells round them no two opposite ones are here.
  [[nodiscard]] bool is_pinched(const GridEdge& edge) const {
    if (edge.low.maxCoeff() == kBlockCells) return false;
    const std::uint64_t edges =
        topology_.pinched()[static_cast<std::size_t>(edge.axis)][static_cast<std::size_t>(edge.low.x())];
    return ((edges >> (kBlockCells * edge.low.y() + edge.low.z())) & 1) != 0;
  }

  void add_vertex(const SurfaceVertex& vertex) {
    mesh_.positions_m.push_back(vertex.p_world.cast<float>());
    if (has_normals_) mesh_.normals.push_back(vertex.outward.cast<float>());
    if (has_colours_) mesh_.colours.push_back(vertex.rgb());
  }

  const BlockTopology& topology_;
  const VertexSampler& sampler_;
  bool has_normals_;
  bool has_colours_;
  Mesh& mesh_;
  std::array<std::uint32_t, 2 * kPlaces> ids_;  ///< by closure_place; second fans of pinched edges in the second half
};

/// Meshes single leaves of a list that has their neighbours too. Everything that a patch depends on lies in its leaf's
/// ValueBlock, so its mesh is the same whatever else is in the list.
class LeafMesher {
 public:
  LeafMesher(const BlockSource& leaves, const ExtractConfig& config, bool is_inside_high)
      : leaves_(leaves),
        config_(config),
        turns_triangles_(is_inside_high == is_mirrored(leaves)),
        frame_(leaves.T_world_index(), is_inside_high),
        signs_(leaves, config.isovalue) {}

  /// `mesh` comes empty, and stays so where the leaf's cells do not meet the surface.
  void write(std::size_t leaf, const Neighbours& neighbours, Mesh& mesh) const {
    if (signs_.is_plain(neighbours)) return;
    const BlockTopology topology(signs_, neighbours);
    if (topology.active_cells() == VoxelBits{}) return;
    ValueBlock values;
    leaves_.load_values(leaf, values);
    std::optional<ColourBlock> colours;
    if (leaves_.has_colours()) leaves_.load_colours(leaf, colours.emplace());
    const VertexSampler sampler(values, colours ? &*colours : nullptr, leaves_.origins()[leaf], frame_, config_);

    const CellTable& table = CellTable::get();
    PatchWriter writer(topology, sampler, config_.normals, leaves_.has_colours(), mesh);
    topology.for_each_active_cell([&](int x, int y, int z, CornerMask highs) {
      const CellEntry entry = table.simple(highs).needs_values
                                  ? resolve_cell(values, x, y, z, highs, config_.isovalue, config_.decider)
                                  : table.entry(highs, 0);
      writer.write_cell({x, y, z}, entry, turns_triangles_);
    });
    if (config_.normals) fill_missing_normals(mesh);
  }

 private:
  const BlockSource& leaves_;
  const ExtractConfig& config_;
  bool turns_triangles_;  ///< as in MarchingCubes
  SamplingFrame frame_;
  ClassifiedBlocks signs_;
};

/// What became of one affected leaf.
struct Remeshed {
  MeshPatch* patch = nullptr;  ///< the one there was, or null
  bool is_different = false;
  Mesh mesh;  ///< only where it is different; empty: no patch any more
};

/// Meshes the affected leaves, in parallel; those that `volume` does not list have vanished.
std::vector<Remeshed> mesh_leaves(const Origins& affected, const BlockSource& volume, const LeafMesher& mesher,
                                  MeshPatches& patches) {
  std::vector<Remeshed> results(affected.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, affected.size(), kLeavesPerTask), [&](const auto& range) {
    const auto listed = volume.origins();
    auto next = std::lower_bound(listed.begin(), listed.end(), affected[range.begin()], is_before);
    NeighbourWalk walk(listed);
    Mesh mesh;  // used again and again; patches get copies without spare room
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      next = std::find_if(next, listed.end(), [&](const auto& origin) { return !is_before(origin, affected[i]); });
      clear(mesh);
      if (next != listed.end() && *next == affected[i]) {
        const auto leaf = static_cast<std::size_t>(next - listed.begin());
        mesher.write(leaf, walk.of(leaf), mesh);
      }
      const auto patch = patches.find(affected[i]);
      Remeshed& result = results[i];
      if (patch != patches.end()) result.patch = &patch->second;
      result.is_different = result.patch != nullptr ? !is_same(result.patch->mesh, mesh) : !mesh.empty();
      if (result.is_different) result.mesh = mesh;
    }
  });
  return results;
}

}  // namespace

IncrementalMesher::IncrementalMesher(const FieldView& view, const ExtractConfig& config, VdbBlocks volume)
    : view_(view), config_(config), volume_(std::move(volume)) {}

Result<IncrementalMesher> IncrementalMesher::create(const FieldView& view, const ExtractConfig& config) {
  SCANKNIT_CHECK(view.field != nullptr);
  if (auto sound = check_extract_config(config); !sound) return sound.error();
  if (is_tetrahedral(config.decider))
    return Error{ErrorCode::kConfig, "tetrahedra are not for live meshes; choose another decider", "extract.decider"};
  try {
    if (view.field->tree().activeTileCount() > 0) return update_error("it has active tiles; voxelize them first");
    auto volume = VdbBlocks::open(view, config.min_weight);
    if (!volume) return volume.error();
    return IncrementalMesher(view, config, volume->restricted_to({}));
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kBudget, "memory ran out; use larger voxels or crop the volume", "extract"};
  } catch (const std::exception& fault) {  // OpenVDB
    return Error{ErrorCode::kInput, fault.what(), "volume"};
  }
}

Result<std::vector<Eigen::Vector3i>> IncrementalMesher::update(std::span<const Eigen::Vector3i> changed) {
  try {
    const auto leaf_at = view_.field->getConstAccessor();
    for (const Eigen::Vector3i& origin : changed) {
      SCANKNIT_CHECK(((origin.x() | origin.y() | origin.z()) & (kBlockCells - 1)) == 0);
      if (is_at_the_end(origin))
        return update_error("it reaches the end of OpenVDB's 32-bit coordinates; move it towards the origin first");
      const openvdb::Coord at(origin.x(), origin.y(), origin.z());
      if (leaf_at.probeConstLeaf(at) == nullptr && leaf_at.isValueOn(at))
        return update_error("it has got an active tile; voxelize it first");
    }
    return remesh(changed);
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kBudget, "memory ran out; use larger voxels or crop the volume", "extract"};
  } catch (const std::exception& fault) {  // OpenVDB
    return Error{ErrorCode::kInput, fault.what(), "volume"};
  }
}

std::vector<Eigen::Vector3i> IncrementalMesher::remesh(std::span<const Eigen::Vector3i> changed) {
  Origins leaves(changed.begin(), changed.end());
  std::sort(leaves.begin(), leaves.end(), is_before);
  leaves.erase(std::unique(leaves.begin(), leaves.end()), leaves.end());

  // A leaf's cells use samples 0 to 8; gradients, the search for a colour and the knit rule look one sample further.
  const bool looks_further = config_.normals || volume_.has_colours() || config_.decider == Decider::kKnit;
  const Origins affected = dilated(std::move(leaves), looks_further ? Around::kAll : Around::kLower);
  const VdbBlocks volume = volume_.restricted_to(dilated(affected, Around::kAll));
  const LeafMesher mesher(volume, config_, is_inside_high(config_.inside, view_.is_signed_distance));
  std::vector<Remeshed> results = mesh_leaves(affected, volume, mesher, patches_);

  // First all that may throw.
  Origins different;
  MeshPatches added;
  for (std::size_t i = 0; i < affected.size(); ++i) {
    if (!results[i].is_different) continue;
    different.push_back(affected[i]);
    if (results[i].patch != nullptr) continue;
    added.emplace_hint(added.end(), affected[i], MeshPatch{affected[i], revision_ + 1, std::move(results[i].mesh)});
  }
  if (different.empty()) return different;
  ++revision_;
  for (std::size_t i = 0; i < affected.size(); ++i) {
    auto& [patch, is_different, mesh] = results[i];
    if (!is_different || patch == nullptr) continue;
    if (mesh.empty()) {
      patches_.erase(affected[i]);
    } else {
      patch->mesh = std::move(mesh);
      patch->revision = revision_;
    }
  }
  patches_.merge(added);
  return different;
}

Result<Mesh> IncrementalMesher::mesh() const {
  std::size_t vertices = 0;
  std::size_t triangles = 0;
  for (const auto& [origin, patch] : patches_) {
    vertices += patch.mesh.positions_m.size();
    triangles += patch.mesh.triangles.size();
  }
  if (vertices > kMaxMeshVertices) return too_many_vertices();

  Mesh all;
  all.positions_m.reserve(vertices);
  all.normals.reserve(config_.normals ? vertices : 0);
  all.colours.reserve(volume_.has_colours() ? vertices : 0);
  all.triangles.reserve(triangles);
  for (const auto& [origin, patch] : patches_) {
    const auto first = static_cast<std::uint32_t>(all.positions_m.size());
    const Mesh& part = patch.mesh;
    all.positions_m.insert(all.positions_m.end(), part.positions_m.begin(), part.positions_m.end());
    all.normals.insert(all.normals.end(), part.normals.begin(), part.normals.end());
    all.colours.insert(all.colours.end(), part.colours.begin(), part.colours.end());
    for (const Triangle& t : part.triangles) all.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  }
  return all;
}

}  // namespace scanknit
