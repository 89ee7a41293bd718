#include "app/terminal/summary.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <numbers>
#include <vector>

#include "app/config/quantity.h"
#include "app/scan/align_output.h"
#include "app/scan/finish_surface.h"

namespace scanknit {
namespace {

/// "1,234,567"
std::string grouped(std::size_t count) {
  std::string digits = std::to_string(count);
  for (std::size_t place = digits.size(); place > 3; place -= 3) digits.insert(place - 3, ",");
  return digits;
}

std::string frames_line(const RunReport& report) {
  const RunReport::Frames& frames = report.frames;
  if (frames.read == 0) return "";  // a volume was meshed
  const std::string dropped = frames.dropped == 0 ? "" : fmt::format(", {} dropped", frames.dropped);
  return fmt::format("Frames   {} of {} fused{}\n", frames.fused, frames.read, dropped);
}

std::string tracking_line(const RunReport& report) {
  if (!report.tracking) return "";
  std::vector<std::string> parts;
  for (const auto& [state, count] : report.tracking->states) parts.push_back(fmt::format("{} {}", count, state));
  return fmt::format("Tracking {}\n", fmt::join(parts, ", "));
}

const char* angle_remark(const RunReport::Turntable& table) {
  if (table.is_angle_held) return "";
  return table.prior == "none" ? "; it looks alike from all sides: the angles are not sure"
                               : "; the pictures do not hold the angles: they are those that were given";
}

std::string turntable_line(const RunReport& report) {
  if (!report.turntable) return "";
  const RunReport::Turntable& table = *report.turntable;
  if (!table.is_refined) return fmt::format("Table    none: {}; left as tracked\n", table.reason);
  if (table.prior == "recording") return fmt::format("Table    {:.2f} turns, poses of the recording\n", table.turns);
  return fmt::format("Table    {:.2f} turns{}, {:.2f} mm and {:.2f} degrees left between frames{}\n", table.turns,
                     table.is_closed ? ", closed" : "", table.rms_m * 1000, table.rms_rad * 180 / std::numbers::pi,
                     angle_remark(table));
}

std::string volume_line(const RunReport& report) {
  const RunReport::Volume& volume = report.volume;
  if (volume.dims[0] > 0) {
    const auto millimetres = [&](std::size_t axis) { return volume.spacing_m[axis] * 1000; };
    return fmt::format(
        "Volume   {}, {} samples of {:.4g} x {:.4g} x {:.4g} mm, {}\n", volume.format, fmt::join(volume.dims, " x "),
        millimetres(0), millimetres(1), millimetres(2),
        volume.is_streamed ? "read a few slices at a time" : fmt::format("{:.0f} MiB", volume.memory_mib));
  }
  return fmt::format("Volume   {} voxels of {}, {:.0f} MiB{}\n", grouped(volume.active_voxels),
                     format_length(volume.voxel_size_m), volume.memory_mib,
                     volume.is_budget_reached ? " (the memory budget was reached: incomplete)" : "");
}

std::string isovalue_line(const RunReport& report) {
  const RunReport::Extract& extract = report.extract;
  if (!extract.isovalue || extract.isovalue_source != "otsu") return "";
  return fmt::format("Isovalue {}, proposed by Otsu's method\n", format_number(*extract.isovalue));
}

std::string mesh_line(const RunReport& report) {
  const MeshCheck& mesh = *report.mesh;
  const Eigen::Vector3f size_mm = (mesh.max_m - mesh.min_m) * 1000.0f;
  const std::string pieces = fmt::format(", {} piece{}", grouped(mesh.components), mesh.components == 1 ? "" : "s");
  return fmt::format("Mesh     {} triangles, {} vertices{}; {:.0f} x {:.0f} x {:.0f} mm\n", grouped(mesh.triangles),
                     grouped(mesh.vertices), report.is_mesh_checked ? pieces : ", not checked", size_mm.x(),
                     size_mm.y(), size_mm.z());
}

/// "0.42 mm", "98 mm": two digits, or all of those before the point.
std::string texel_words(double texel_m) {
  const double texel_mm = 1000 * texel_m;
  return texel_mm < 10 ? fmt::format("{:.2g} mm", texel_mm) : fmt::format("{:.0f} mm", texel_mm);
}

std::string texture_line(const RunReport& report) {
  if (!report.texture) return "";
  const RunReport::Texture& texture = *report.texture;
  if (!texture.refused.empty()) return fmt::format("Texture  none: {}\n", texture.refused);
  return fmt::format("Texture  {} x {}, texels of {}, {:.1f} % seen by {} frames\n", texture.width, texture.height,
                     texel_words(texture.texel_m), 100 * texture.seen_share, texture.frames);
}

std::string time_line(const RunReport& report) {
  std::vector<std::string> parts;
  for (const char* stage : {"read", "acquire", "filter", "track", "raycast", "integrate", "refine", "fuse_again",
                            "extract", "finish", "texture", "export", "write"}) {
    const auto found = report.stages.find(stage);
    if (found == report.stages.end() || found->second.samples_ms.empty()) continue;
    parts.push_back(fmt::format("{} {:.2f}", stage, found->second.total_ms() / 1000));
  }
  return fmt::format("Seconds  {:.2f} ({}), at most {:.0f} MiB of memory\n", report.total_ms / 1000,
                     fmt::join(parts, ", "), report.peak_rss_mib);
}

std::string files_line(const RunReport& report) {
  std::vector<std::string> paths;
  for (const auto& [kind, path] : report.files) paths.push_back(path);
  return fmt::format("Written  {}\n", fmt::join(paths, "\n         "));
}

/// One suggestion that fits what was seen.
std::string next_line(const RunReport& report) {
  std::vector<std::string> ideas;
  if (report.files.contains("glb"))
    ideas.push_back(fmt::format("open {} in Blender or any glTF viewer", report.files.at("glb")));
  if (report.volume.is_budget_reached) {
    ideas.push_back("complete it: a larger fusion.voxel_size or fusion.memory_budget");
  } else if (report.frames.read > 0) {
    ideas.push_back(
        fmt::format("finer: --set fusion.voxel_size={}mm", format_number(report.volume.voxel_size_m * 500)));
  }
  return ideas.empty() ? "" : fmt::format("Next     {}\n", fmt::join(ideas, "\n         "));
}

}  // namespace

std::string summary_text(const RunReport& report) {
  std::string text = frames_line(report) + tracking_line(report) + turntable_line(report) + alignment_text(report) +
                     volume_line(report) + isovalue_line(report);
  text += finish_text(report);
  if (report.mesh) text += mesh_line(report);
  return text + texture_line(report) + time_line(report) + files_line(report) + next_line(report);
}

}  // namespace scanknit
