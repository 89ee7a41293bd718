#include "extract/extract_surface.h"

#include <cmath>
#include <exception>
#include <new>
#include <optional>
#include <utility>

#include "core/check.h"
#include "core/system/freed_memory.h"
#include "extract/blocks/dense_blocks.h"
#include "extract/blocks/vdb_blocks.h"
#include "extract/cell/case_histogram.h"
#include "extract/marching_cubes.h"
#include "extract/reference/marching_tetrahedra.h"
#include "extract/smooth_normals.h"

namespace scanknit {
namespace {

std::optional<TetraSplit> tetra_split(Decider decider) {
  switch (decider) {
    case Decider::kTetra5: return TetraSplit::k5;
    case Decider::kTetra6: return TetraSplit::k6;
    case Decider::kTetra24: return TetraSplit::k24;
    default: return std::nullopt;
  }
}

Result<Surface> march_cubes(const BlockSource& source, const ExtractConfig& config, bool is_inside_high) {
  const BlockRange all{0, source.origins().size()};
  Surface surface;
  MarchingCubes marching(source, config, is_inside_high);
  CaseHistogram histogram;
  marching.count(all, histogram);
  surface.cases = histogram.counts(is_mirrored(source));
  if (marching.size_of(all).vertices > kMaxMeshVertices) return too_many_vertices();
  marching.number(0);
  marching.write(all, surface.mesh);
  if (config.normals) fill_missing_normals(surface.mesh);
  return surface;
}

Result<Surface> march_tetrahedra(const BlockSource& source, TetraSplit split, const ExtractConfig& config,
                                 bool is_inside_high) {
  auto mesh = march_tetrahedra(source, split, config.isovalue, config.placement, is_inside_high, config.normals);
  if (!mesh) return mesh.error();
  return Surface{std::move(*mesh), {}};
}

Result<Surface> extract(const BlockSource& source, const ExtractConfig& config, bool is_inside_high) {
  const auto split = tetra_split(config.decider);
  Result<Surface> surface =
      split ? march_tetrahedra(source, *split, config, is_inside_high) : march_cubes(source, config, is_inside_high);
  if (surface && config.min_component_triangles > 1) {
    return_freed_memory();
    surface->cases.components_removed = remove_small_components(surface->mesh, config.min_component_triangles);
  }
  return surface;
}

/// Runs extraction where the source opens, and turns what libraries throw into errors.
template <typename Open>
Result<Surface> guarded(const ExtractConfig& config, bool is_inside_high, const Open& open) {
  if (auto sound = check_extract_config(config); !sound) return sound.error();
  try {
    const auto source = open();
    return source ? extract(*source, config, is_inside_high) : Result<Surface>(source.error());
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kBudget, "memory ran out; use larger voxels or crop the volume", "extract"};
  } catch (const std::exception& fault) {  // OpenVDB
    return Error{ErrorCode::kInput, fault.what(), "volume"};
  }
}

}  // namespace

Result<void> check_extract_config(const ExtractConfig& config) {
  if (!std::isfinite(config.isovalue)) return Error{ErrorCode::kConfig, "must be a finite number", "extract.isovalue"};
  if (!std::isfinite(config.min_weight) || config.min_weight < 0)
    return Error{ErrorCode::kConfig, "must be a finite number, 0 or more", "extract.min_weight"};
  return {};
}

Result<Surface> extract_surface(const FieldView& view, const ExtractConfig& config) {
  SCANKNIT_CHECK(view.field != nullptr);
  return guarded(config, is_inside_high(config.inside, view.is_signed_distance),
                 [&] { return VdbBlocks::open(view, config.min_weight); });
}

Result<Surface> extract_surface(const DenseView& volume, const ExtractConfig& config) {
  SCANKNIT_CHECK(volume.samples != nullptr);
  return guarded(config, is_inside_high(config.inside, false), [&] { return DenseBlocks::open(volume); });
}

}  // namespace scanknit
