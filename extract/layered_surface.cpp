#include "extract/layered_surface.h"

#include <algorithm>
#include <exception>
#include <new>

#include "extract/blocks/vdb_blocks.h"
#include "extract/cell/case_histogram.h"
#include "extract/marching_cubes.h"
#include "extract/smooth_normals.h"

namespace scanknit {
namespace {

/// `share`: of the blocks, those of `all` with `part`. A vector that grows is in memory twice; room for what is still
/// to come takes none before it is used.
template <typename T>
void append_part(std::vector<T>& all, const std::vector<T>& part, double share) {
  constexpr double kSpare = 1.25;
  const std::size_t size = all.size() + part.size();
  if (size > all.capacity()) {
    all.reserve(std::max(size, static_cast<std::size_t>(kSpare * static_cast<double>(size) / share)));
  }
  all.insert(all.end(), part.begin(), part.end());
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
  LayerMarch(LayeredField& field, const ExtractConfig& config) : field_(field), config_(config) {
    for (const BlockLayer& layer : field.layers()) blocks_ += layer.blocks;
  }

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
    marching.number(surface_.mesh.positions_m.size());
    if (surface_.mesh.positions_m.size() + marching.size_of(own).vertices > kMaxMeshVertices) {
      return too_many_vertices();
    }
    marching.write(own, part_);
    blocks_done_ += own.size();
    const double share = static_cast<double>(blocks_done_) / static_cast<double>(blocks_);
    append_part(surface_.mesh.positions_m, part_.positions_m, share);
    append_part(surface_.mesh.normals, part_.normals, share);
    append_part(surface_.mesh.colours, part_.colours, share);
    append_part(surface_.mesh.triangles, part_.triangles, share);
    return {};
  }

  /// After the last step.
  [[nodiscard]] Surface surface() {
    surface_.cases = histogram_.counts(is_mirrored_);
    if (config_.normals) fill_missing_normals(surface_.mesh);
    if (config_.min_component_triangles > 1) {
      surface_.cases.components_removed = remove_small_components(surface_.mesh, config_.min_component_triangles);
      Mesh& mesh = surface_.mesh;  // what was removed has taken memory
      mesh.positions_m.shrink_to_fit();
      mesh.normals.shrink_to_fit();
      mesh.colours.shrink_to_fit();
      mesh.triangles.shrink_to_fit();
    }
    return std::move(surface_);
  }

 private:
  LayeredField& field_;
  const ExtractConfig& config_;
  std::size_t blocks_ = 0, blocks_done_ = 0;
  CaseHistogram histogram_;
  bool is_mirrored_ = false;
  Surface surface_;
  Mesh part_;
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
