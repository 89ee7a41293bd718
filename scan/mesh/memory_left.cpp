#include "scan/mesh/memory_left.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/field_view.h"
#include "finish/mesh_steps.h"
#include "scan/checks/memory_share.h"

namespace scanknit {

std::size_t bytes_of(const Mesh& mesh) {
  return mesh.positions_m.size() * sizeof(Eigen::Vector3f) + mesh.normals.size() * sizeof(Eigen::Vector3f) +
         mesh.colours.size() * sizeof(Rgb8) + mesh.triangles.size() * sizeof(Triangle);
}

std::size_t bytes_of(const FieldView& view) {
  std::size_t bytes = 0;
  const auto add = [&](const auto* grid) { bytes += grid != nullptr ? static_cast<std::size_t>(grid->memUsage()) : 0; };
  add(view.field);
  add(view.weight);
  add(view.colour);
  add(view.weight_codes);
  add(view.colour_codes);
  return bytes;
}

std::size_t memory_left_bytes(std::size_t memory_budget_mib, std::size_t taken_bytes) {
  const std::size_t for_all = (memory_budget_mib - std::min(memory_budget_mib, kProgramMib)) << 20;
  return for_all - std::min(for_all, taken_bytes);
}

bool has_room_to_check_beside(const Mesh& mesh, const ScanConfig& config) {
  constexpr std::size_t kBytesPerTriangle = 60;  // of check_mesh(), find_holes(), find_doubled_surface() and writing
  const std::size_t left = memory_left_bytes(config.fusion.memory_budget_mib, bytes_of(mesh));
  return left >= kBytesPerTriangle * mesh.triangles.size();
}

std::optional<std::string> too_large_to_simplify(const Mesh& mesh, const ScanConfig& config, std::size_t held_bytes) {
  constexpr std::size_t kMebibyte = 1 << 20;
  const FinishConfig& finish = config.finish;
  const bool has_less = finish.triangles.value_or(mesh.triangles.size()) < mesh.triangles.size();
  if (!has_less && !finish.simplify_error_m) return std::nullopt;
  const std::size_t needed = simplify_bytes(mesh);
  const std::size_t left = memory_left_bytes(config.fusion.memory_budget_mib, held_bytes + bytes_of(mesh));
  if (needed <= left) return std::nullopt;
  return fmt::format(
      "{} triangles take {} MiB to simplify; {} are left of fusion.memory_budget: raise it, or take "
      "larger voxels",
      mesh.triangles.size(), needed / kMebibyte + 1, left / kMebibyte);
}

}  // namespace scanknit
