// What the volume and the mesh leave of the memory budget to the steps that finish the mesh.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "core/mesh.h"
#include "scan/scan_config.h"

namespace scanknit {

struct FieldView;

[[nodiscard]] std::size_t bytes_of(const Mesh& mesh);
/// Of the grids of the view, with their trees.
[[nodiscard]] std::size_t bytes_of(const FieldView& view);

/// Of fusion.memory_budget, without what the program takes (scan/checks/memory_share.h) and `taken_bytes`; 0 if nothing
/// is left.
[[nodiscard]] std::size_t memory_left_bytes(std::size_t memory_budget_mib, std::size_t taken_bytes);

/// Whether there is memory to check the mesh while its files are written.
[[nodiscard]] bool has_room_to_check_beside(const Mesh& mesh, const ScanConfig& config);

/// Why the simplification that `config` asks for would take more than what the mesh and `held_bytes` leave. Nothing: it
/// fits, or there is nothing to simplify.
[[nodiscard]] std::optional<std::string> too_large_to_simplify(const Mesh& mesh, const ScanConfig& config,
                                                               std::size_t held_bytes);

}  // namespace scanknit
