#include "extract/layered_surface.h"

#include <algorithm>
#include <exception>
#include <new>

#include "core/mesh/unused_vertices.h"
#include "core/system/freed_memory.h"
#include "extract/blocks/vdb_blocks.h"
#include "extract/cell/case_histogram.h"
#include "extract/marching_cubes.h"
#include "extract/smooth_normals.h"

namespace scanknit {
namespace {

/// Moves an array of the parts into the whole mesh, a few megabytes after the other: a vector that grew by them would
/// be in memory twice.
template <typename T>
void join(std::vector<Mesh>& parts, std::vector<T> Mesh::*array, Mesh& whole) {
  constexpr std::size_t kWorthReturning = 32 << 20;  // bytes
  std::size_t size = 0, freed = 0;
  for (const Mesh& part : parts) size += (part.*array).size();
  (whole.*array).reserve(size);
  for (Mesh& part : parts) {
    (whole.*array).insert((whole.*array).end(), (part.*array).begin(), (part.*array).end());
    freed += (part.*array).size() * sizeof(T);
    part.*array = std::vector<T>();
    if (freed < kWorthReturning) continue;
    return_freed_memory();
    freed = 0;
  }
  return_freed_memory();
}

/// The blocks of a list, sorted by is_before, with begin_x <= x < end_x.
BlockRange blocks_between(std::span<const Eigen::Vector3i> origins, int begin_x, int end_x) {
  const auto first_from = [&](int x) {
    const auto found = std::partition_point(origins.begin(), origins.end(),
                                            [&](const Eigen::Vector3i& origin) { return origin.x() < x; });
    return static_cast<std::size_t>(found - origins.begin());
  };
  return {first_from(begin_x), first_from(end_x)};
}

class LayerMarch {
 public:
  LayerMarch(LayeredField& field, const ExtractConfig& config) : field_(field), config_(config) {}

  /// Meshes the blocks with begin_x <= x < end_x, which follow those of the last step.
  [[nodiscard]] Result<void> step(int begin_x, int end_x) {
    const auto view = field_.read(begin_x - kBlockCells, end_x + 2 * kBlockCells);
    if (!view) return view.error();
    const auto source = VdbBlocks::open(*view, config_.min_weight);
    if (!source) return source.error();
    is_mirrored_ = is_mirrored(*source);
    MarchingCubes marching(*source, config_, is_inside_high(config_.inside, view->is_signed_distance));
    const BlockRange own = blocks_between(source->origins(), begin_x, end_x);
    CaseHistogram others;
    marching.count(own, histogram_);
    marching.count(blocks_between(source->origins(), end_x, end_x + kBlockCells), others);
    marching.number(vertices_);
    vertices_ += marching.size_of(own).vertices;
    if (vertices_ > kMaxMeshVertices) return too_many_vertices();
    marching.write(own, parts_.emplace_back());
    return {};
  }

  /// After the last step.
  [[nodiscard]] Surface surface() {
    field_.let_go();
    Surface surface;
    surface.cases = histogram_.counts(is_mirrored_);
    Mesh& mesh = surface.mesh;
    join(parts_, &Mesh::positions_m, mesh);
    join(parts_, &Mesh::normals, mesh);
    join(parts_, &Mesh::colours, mesh);
    join(parts_, &Mesh::triangles, mesh);
    if (config_.normals) fill_missing_normals(mesh);
    if (config_.min_component_triangles > 1) {
      surface.cases.components_removed = remove_small_components(mesh, config_.min_component_triangles);
      return_unused_memory(mesh);
    }
    return surface;
  }

 private:
  LayeredField& field_;
  const ExtractConfig& config_;
  CaseHistogram histogram_;
  bool is_mirrored_ = false;
  std::size_t vertices_ = 0;  ///< of the parts
  std::vector<Mesh> parts_;   ///< one of each step
};

Result<Surface> march_layers(LayeredField& field, const ExtractConfig& config, std::size_t blocks_at_once) {
  if (auto sound = check_extract_config(config); !sound) return sound.error();
  if (is_tetrahedral(config.decider)) {
    return Error{ErrorCode::kConfig, "tetrahedra are not extracted from a volume in bricks; choose another",
                 "extract.decider"};
  }
  LayerMarch march(field, config);
  const auto layers = field.layers();
  for (std::size_t begin = 0, end = 0; begin < layers.size(); begin = end) {
    std::size_t blocks = layers[end++].blocks;
    while (end < layers.size() && blocks + layers[end].blocks <= blocks_at_once) blocks += layers[end++].blocks;
    if (auto done = march.step(layers[begin].x, layers[end - 1].x + kBlockCells); !done) return done.error();
  }
  return march.surface();
}

}  // namespace

Result<Surface> extract_surface(LayeredField& field, const ExtractConfig& config, std::size_t blocks_at_once) {
  try {
    return march_layers(field, config, blocks_at_once);
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kBudget, "memory ran out; use larger voxels or crop the volume", "extract"};
  } catch (const std::exception& fault) {  // OpenVDB
    return Error{ErrorCode::kInput, fault.what(), "volume"};
  }
}

}  // namespace scanknit
