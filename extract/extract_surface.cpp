#include "extract/extract_surface.h"

#include <cmath>
#include <exception>
#include <new>

#include "core/check.h"
#include "extract/marching_cubes.h"
#include "extract/vdb_blocks.h"

namespace scanknit {
namespace {

bool is_inside_high(const FieldView& view, const ExtractConfig& config) {
  if (config.inside == InsideSide::kAuto) return !view.is_signed_distance;
  return config.inside == InsideSide::kHigh;
}

Result<Surface> extract(const FieldView& view, const ExtractConfig& config) {
  Result<VdbBlocks> blocks = VdbBlocks::open(view, config.min_weight);
  if (!blocks) return blocks.error();
  Result<Surface> surface = march_cubes(*blocks, config, is_inside_high(view, config));
  if (surface && config.min_component_triangles > 1) {
    surface->cases.components_removed = remove_small_components(surface->mesh, config.min_component_triangles);
  }
  return surface;
}

}  // namespace

Result<Surface> extract_surface(const FieldView& view, const ExtractConfig& config) {
  SCANKNIT_CHECK(view.field != nullptr);
  if (!std::isfinite(config.isovalue)) return Error{ErrorCode::kConfig, "must be a finite number", "extract.isovalue"};
  if (!std::isfinite(config.min_weight) || config.min_weight < 0)
    return Error{ErrorCode::kConfig, "must be a finite number, 0 or more", "extract.min_weight"};
  try {
    return extract(view, config);
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kBudget, "memory ran out; use larger voxels or crop the volume", "extract"};
  } catch (const std::exception& fault) {  // OpenVDB
    return Error{ErrorCode::kInput, fault.what(), "volume"};
  }
}

}  // namespace scanknit
