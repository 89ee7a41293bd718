// Smaller GLB files: KHR_mesh_quantization and EXT_meshopt_compression. Private to the GLB writer and reader.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/files/atomic_file.h"
#include "core/limits.h"
#include "core/mesh.h"
#include "core/result.h"
#include "export/export_config.h"
#include "export/glb/placement.h"
#include "export/mesh/mesh_writers.h"

namespace scanknit {

/// As write_glb(), with config.quantize or config.compress. Quantized: positions in 1/65535 of the longest side of the
/// box, normals in 1/127. Compressed: vertices and triangles in another order. Colours are exact in both.
/// Texture coordinates are in 1/65535 when quantized. Primitives share one grid: what was one vertex stays at one
/// place.
[[nodiscard]] Result<void> write_packed_glb(const Mesh& mesh, const Placement& placement, const ExportConfig& config,
                                            AtomicFile& file, const MeshTexture* texture = nullptr,
                                            const GlbLimits& limits = {});

/// The same GLB without EXT_meshopt_compression; nothing when it does not use it. `glb` has passed
/// check_glb_container(). Errors: kInput for what cannot be decoded, or would become larger than is believed. May throw
/// what nlohmann-json throws.
[[nodiscard]] Result<std::optional<std::string>> without_meshopt(std::string_view glb, const Limits& limits);

}  // namespace scanknit
