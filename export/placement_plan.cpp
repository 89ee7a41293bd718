#include "export/placement_plan.h"

#include <fmt/format.h>

#include <cstdint>
#include <limits>
#include <system_error>

#include "export/mesh/up_rotation.h"

namespace scanknit {
namespace {

std::string unit_name(double metres) {
  if (metres == 1) return "metres";
  if (metres == 1e-2) return "centimetres";
  if (metres == 1e-3) return "millimetres";
  if (metres == 1e-6) return "micrometres";
  return fmt::format("units of {} m", metres);
}

}  // namespace

PlacementPlan plan_placement(MeshFormat format, const ExportConfig& config, UpAxis world_up,
                             std::optional<double> file_unit_m) {
  const UpAxis from = config.world_up.value_or(world_up);
  const std::string unit = unit_name(file_unit_m.value_or(1));
  switch (format) {
    case MeshFormat::kGlb:
    case MeshFormat::kTiles: {  // the tiles are GLB; 3D Tiles 1.1 turns their Y up to its Z up
      const auto scale = static_cast<float>(file_unit_m.value_or(1));
      const char* convention = format == MeshFormat::kGlb ? "metres, Y up" : "metres, Z up";
      return {format, {up_rotation(from, UpAxis::kY), scale, "metres"}, convention};
    }
    case MeshFormat::kStl: {
      const Placement in_millimetres{up_rotation(from, UpAxis::kZ), 1000, "millimetres"};
      const Placement as_it_is{in_millimetres.rotation, 1, unit};
      const Placement& placement = file_unit_m ? as_it_is : in_millimetres;
      return {format, placement, placement.unit + ", Z up"};
    }
    case MeshFormat::kThreeMf: {
      const auto scale = static_cast<float>(1000 * file_unit_m.value_or(1));
      return {format, {up_rotation(from, UpAxis::kZ), scale, "millimetres"}, "millimetres, Z up"};
    }
    case MeshFormat::kPly:
    case MeshFormat::kObj:
    case MeshFormat::kStep: break;
  }
  const char* own_axes = file_unit_m ? ", the volume's own axes" : ", the recording's world";
  if (!config.up) return {format, {up_rotation(from, from), 1, unit}, unit + own_axes};
  return {format, {up_rotation(from, *config.up), 1, unit}, fmt::format("{}, {} up", unit, to_string(*config.up))};
}

Result<void> check_counts(std::size_t vertices, std::size_t triangles) {
  constexpr std::size_t kMaxCount = std::numeric_limits<std::int32_t>::max();
  if (vertices <= kMaxCount && triangles <= kMaxCount) return {};
  return Error{ErrorCode::kMesh,
               "the mesh has more than 2^31 - 1 vertices or triangles: take larger voxels, or crop the volume"};
}

WrittenFile written_file(const std::filesystem::path& path, const PlacementPlan& plan) {
  std::error_code code;
  const std::uintmax_t bytes = std::filesystem::file_size(path, code);
  return {path, code ? 0 : bytes, plan.convention};
}

}  // namespace scanknit
