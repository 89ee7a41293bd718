#include "app/report/summary.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <numbers>
#include <vector>

#include "app/report/report_json.h"
#include "core/files/quantity.h"
#include "export/report/page_text.h"

namespace scanknit {
namespace {

constexpr double kWorthSaying = 0.005;  // share of the surface in two sheets

/// "1,234,567"
std::string grouped(std::size_t count) {
  std::string digits = std::to_string(count);
  for (std::size_t place = digits.size(); place > 3; place -= 3) digits.insert(place - 3, ",");
  return digits;
}

std::string frames_line(const ScanResult& scan) {
  const FrameCounts& frames = scan.frames;
  if (frames.read == 0) return "";  // there are no frames: a volume was meshed
  const std::string dropped = frames.dropped == 0 ? "" : fmt::format(", {} dropped", frames.dropped);
  return fmt::format("Frames   {} of {} fused{}\n", frames.fused, frames.read, dropped);
}

std::string tracking_line(const ScanResult& scan) {
  if (!scan.tracking) return "";
  std::map<std::string, std::size_t> states;
  for (const TrackedFrame& frame : scan.tracking->frames) ++states[to_string(frame.state)];
  std::vector<std::string> parts;
  for (const auto& [state, count] : states) parts.push_back(fmt::format("{} {}", count, state));
  const std::size_t later = scan.tracking->found_later;
  const std::string remark = later == 0 ? "" : fmt::format("; {} of them lost at first, and found later", later);
  return fmt::format("Tracking {}{}\n", fmt::join(parts, ", "), remark);
}

const char* angle_remark(const TurntableResult& table) {
  if (table.is_angle_held) return "";
  return table.prior == AngleSource::kNone ? "; it looks the same from all sides: the angles are uncertain"
                                           : "; the pictures do not determine the angles: the given ones are used";
}

std::string turntable_line(const ScanResult& scan) {
  if (!scan.turntable) return "";
  const TurntableResult& table = *scan.turntable;
  if (!table.is_refined) return fmt::format("Table    none: {}; left as tracked\n", table.reason);
  if (table.prior == AngleSource::kRecording)
    return fmt::format("Table    {:.2f} turns, poses of the recording\n", table.turns);
  return fmt::format("Table    {:.2f} turns{}, {:.2f} mm and {:.2f} degrees left between frames{}\n", table.turns,
                     table.is_closed ? ", closed" : "", table.rms_m * 1000, table.rms_rad * 180 / std::numbers::pi,
                     angle_remark(table));
}

std::string volume_line(const ScanResult& scan) {
  const VolumeResult& volume = scan.volume;
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

std::string isovalue_line(const ScanResult& scan) {
  const MeshResult& mesh = scan.mesh;
  if (!mesh.isovalue || mesh.isovalue_source != IsovalueSource::kOtsu) return "";
  return fmt::format("Isovalue {}, proposed by Otsu's method\n", format_number(*mesh.isovalue));
}

/// `heading`: "Mesh", or the name of a class. `made` has been checked.
std::string mesh_line(const std::string& heading, const MeshResult& made) {
  const MeshCheck& mesh = *made.check;
  const Eigen::Vector3f size_mm = (mesh.max_m - mesh.min_m) * 1000.0f;
  const std::string pieces = fmt::format(", {} piece{}", grouped(mesh.components), mesh.components == 1 ? "" : "s");
  const auto& doubled = made.doubled;
  const bool is_doubled = doubled && doubled->share > kWorthSaying;
  const std::string sheets = is_doubled ? fmt::format("; {:.1f} % in two sheets", 100 * doubled->share) : "";
  return fmt::format("{:<9}{} triangles, {} vertices{}; {:.0f} x {:.0f} x {:.0f} mm{}\n", heading,
                     grouped(mesh.triangles), grouped(mesh.vertices), made.is_checked ? pieces : ", not checked",
                     size_mm.x(), size_mm.y(), size_mm.z(), sheets);
}

/// A line for each class that has a mesh.
std::string classes_text(const std::vector<ClassResult>& classes) {
  std::string text;
  for (const ClassResult& one : classes) {
    const bool has_mesh = one.mesh.check && one.mesh.check->triangles > 0;
    if (has_mesh) text += mesh_line(fmt::format("Class {} ", one.label), one.mesh);
  }
  return text;
}

/// "0.42 mm", "98 mm": two significant digits, or all digits before the point.
std::string texel_words(double texel_m) {
  const double texel_mm = 1000 * texel_m;
  return texel_mm < 10 ? fmt::format("{:.2g} mm", texel_mm) : fmt::format("{:.0f} mm", texel_mm);
}

std::string texture_line(const ScanResult& scan) {
  if (!scan.texture) return "";
  const TextureResult& texture = *scan.texture;
  if (!texture.refused.empty()) return fmt::format("Texture  none: {}\n", texture.refused);
  return fmt::format("Texture  {} x {}, texels of {}, {:.1f} % seen by {} frames\n", texture.width, texture.height,
                     texel_words(texture.texel_m), 100 * texture.seen_share, texture.frames);
}

std::string time_line(const CommandRun& run) {
  std::vector<std::string> parts;
  for (const char* stage : {"read",       "acquire",     "filter",  "track",  "raycast", "deskew",     "integrate",
                            "key_frames", "track_later", "loops",   "refine", "align",   "fuse_again", "prepare",
                            "colour",     "agreement",   "extract", "finish", "texture", "export",     "write"}) {
    const auto found = run.scan.stages.find(stage);
    if (found == run.scan.stages.end() || found->second.samples_ms.empty()) continue;
    parts.push_back(fmt::format("{} {:.2f}", stage, found->second.total_ms() / 1000));
  }
  return fmt::format("Seconds  {:.2f} ({}), at most {:.0f} MiB of memory\n", run.total_ms / 1000,
                     fmt::join(parts, ", "), run.peak_rss_mib);
}

std::string files_line(const CommandRun& run) {
  std::vector<std::string> paths;
  for (const auto& [kind, path] : files_of(run)) paths.push_back(path);
  return fmt::format("Written  {}\n", fmt::join(paths, "\n         "));
}

/// Suggests what to do next, from the result.
std::string next_line(const ScanResult& scan) {
  std::vector<std::string> ideas;
  if (scan.files.contains("glb"))
    ideas.push_back(fmt::format("open {} in Blender or any glTF viewer", scan.files.at("glb")));
  if (scan.volume.is_budget_reached) {
    ideas.push_back("complete it: a larger fusion.voxel_size or fusion.memory_budget");
  } else if (scan.frames.read > 0) {
    ideas.push_back(fmt::format("finer: --set fusion.voxel_size={:.3g}mm", scan.volume.voxel_size_m * 500));
  }
  return ideas.empty() ? "" : fmt::format("Next     {}\n", fmt::join(ideas, "\n         "));
}

std::string alignment_text(const ScanResult& scan) {
  if (!scan.alignment) return "";
  std::string text = "Pairs    scans   residual   overlap   in the way   missing   verdict\n";
  for (const auto& pair : scan.alignment->pairs) {
    const auto share = [](const std::optional<double>& value) {
      return value ? fmt::format("{:.1f} %", 100 * *value) : "?";
    };
    text += fmt::format("         {:<7} {:>5.3f} mm {:>7.0f} % {:>11} {:>9}   {}{}{}\n",
                        fmt::format("{} {}", pair.from, pair.to), pair.residual_m * 1000, pair.overlap * 100,
                        share(pair.contradicted), share(pair.missing), to_string(pair.verdict),
                        pair.reason.empty() ? "" : ": ", pair.reason);
  }
  return text;
}

std::string silhouettes_line(const ScanResult& scan) {
  if (!scan.silhouettes) return "";
  return fmt::format("Outline  mesh and masks agree in {:.2f} % of the pixels; least overlap {:.1f} %, in {}\n",
                     100 * scan.silhouettes->agreement, 100 * scan.silhouettes->worst_overlap,
                     scan.silhouettes->worst_picture);
}

/// One line for each finishing step.
std::string finish_text(const ScanResult& scan) {
  if (!scan.mesh.finish) return "";
  std::string text;
  for (const auto& step : scan.mesh.finish->steps) {
    std::vector<std::string> words;
    for (const auto& [name, value] : step.figures) words.push_back(figure_words(name, value));
    text += fmt::format("{:8} {}: {}\n", text.empty() ? "Finish" : "", to_string(step.step),
                        step.refused.empty() ? fmt::format("{}", fmt::join(words, ", ")) : "not done: " + step.refused);
  }
  return text;
}

}  // namespace

std::string summary_text(const CommandRun& run) {
  const ScanResult& scan = run.scan;
  std::string text = frames_line(scan) + tracking_line(scan) + turntable_line(scan) + alignment_text(scan) +
                     silhouettes_line(scan) + volume_line(scan) + isovalue_line(scan);
  text += finish_text(scan);
  if (scan.mesh.check) text += mesh_line("Mesh", scan.mesh);
  text += classes_text(scan.classes);
  return text + texture_line(scan) + time_line(run) + files_line(run) + next_line(scan);
}

}  // namespace scanknit
