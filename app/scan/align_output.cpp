#include "app/scan/align_output.h"

#include <fmt/format.h>

#include <algorithm>

#include "app/scan/finish_surface.h"
#include "app/scan/mesh_output.h"
#include "app/scan/stage_timer.h"
#include "core/files/atomic_file.h"
#include "export/mesh/write_points.h"
#include "export/picture/preview.h"
#include "fusion/integrate/range_integrate.h"

namespace scanknit {
namespace {

constexpr Rgb8 kOrange{230, 120, 30};
constexpr Rgb8 kBlue{40, 110, 210};
constexpr std::size_t kMostDots = 60'000;  // of a scan in a picture

/// A small triangle at each point, across its normal.
void add_dots(const ScanModel& model, const Pose& T, double size_m, Rgb8 colour, Mesh& picture) {
  const OrientedPoints dots = thin_out(model.all, size_m);
  const std::size_t every = std::max<std::size_t>(1, dots.size() / kMostDots);
  for (std::size_t i = 0; i < dots.size(); i += every) {
    const Eigen::Vector3d p = T * dots.points_m[i].cast<double>();
    const Eigen::Vector3d n = T.linear() * dots.normals[i].cast<double>();
    const Eigen::Vector3d u = n.unitOrthogonal() * size_m;
    const Eigen::Vector3d v = n.cross(u);
    const auto first = static_cast<std::uint32_t>(picture.positions_m.size());
    for (const Eigen::Vector3d& corner :
         {Eigen::Vector3d(u), Eigen::Vector3d(-0.5 * u + 0.87 * v), Eigen::Vector3d(-0.5 * u - 0.87 * v)}) {
      picture.positions_m.push_back((p + corner).cast<float>());
      picture.normals.push_back(n.cast<float>());
      picture.colours.push_back(colour);
    }
    picture.triangles.push_back({first, first + 1, first + 2});
  }
}

/// In the first scan's frame as its own file stands upright.
Result<void> write_picture(const AlignInputs& inputs, const Alignment& alignment, const AlignedPair& pair,
                           const std::filesystem::path& path) {
  const bool is_placed = alignment.is_placed[pair.from] && alignment.is_placed[pair.to];
  const Pose& T_world_from = alignment.T_world_scan[pair.from];
  const Pose T_world_to = is_placed ? alignment.T_world_scan[pair.to] : Pose(T_world_from * pair.T_from_to);
  Mesh picture;
  add_dots(inputs.models[pair.from], T_world_from, alignment.scale.fine_m, kOrange, picture);
  add_dots(inputs.models[pair.to], T_world_to, alignment.scale.fine_m, kBlue, picture);
  return write_png(render_preview(picture, inputs.inputs[pair.from].world_up), path);
}

Result<void> fuse_scan(const AlignInput& input, const ScanModel& model, const Pose& T_world_scan, const Job& job,
                       std::stop_token stop, Console& console, TsdfVolume& volume, RunReport& report) {
  if (input.kind == AlignKind::kRange) {
    const auto fused = timed(report, "integrate",
                             [&] { return integrate(model.sights[0].view, input.noise_m, T_world_scan, volume); });
    if (!fused) return fused.error();
    ++report.frames.fused;
    return {};
  }
  auto source = open_recording(input.path, job.config.acquire);
  if (!source) return source.error();
  PosesBySequence poses;
  for (const auto& [sequence, T_scan_camera] : input.T_scan_camera) poses[sequence] = T_world_scan * T_scan_camera;
  const auto fused =
      timed(report, "integrate", [&] { return fuse_again(**source, poses, job.config, volume, stop, console); });
  if (!fused) return fused.error();
  report.frames.fused += *fused;
  return {};
}

Result<void> write_poses(const Alignment& alignment, const std::string& world, const std::filesystem::path& path,
                         RunReport& report) {
  std::vector<StampedPose> poses;
  for (std::size_t i = 0; i < alignment.T_world_scan.size(); ++i) {
    poses.push_back({static_cast<double>(i + 1), alignment.T_world_scan[i]});
  }
  report.files["trajectory"] = path.string();
  const std::string text = "# scan tx ty tz qx qy qz qw; the world is " + world + "\n" + to_tum_trajectory(poses);
  return timed(report, "write", [&] { return write_file_atomically(path, text); });
}

}  // namespace

Result<void> describe_alignment(const AlignInputs& inputs, const Alignment& alignment,
                                const std::optional<std::filesystem::path>& picture_folder, RunReport& report) {
  RunReport::Aligned& told = report.alignment.emplace();
  told.spacing_m = alignment.scale.fine_m;
  for (std::size_t i = 0; i < inputs.inputs.size(); ++i) {
    told.scans.push_back({inputs.inputs[i].name, to_string(inputs.inputs[i].kind), inputs.models[i].all.size(),
                          alignment.is_placed[i], alignment.T_world_scan[i]});
  }
  for (const AlignedPair& pair : alignment.pairs) {
    RunReport::Aligned::Pair line{.from = pair.from + 1,
                                  .to = pair.to + 1,
                                  .verdict = to_string(pair.judgement.verdict),
                                  .reason = pair.judgement.reason,
                                  .start = pair.start,
                                  .residual_m = pair.measure.residual_m,
                                  .overlap = pair.measure.overlap,
                                  .off_m = pair.off_m,
                                  .least_strength = pair.measure.least_strength,
                                  .contradicted = {},
                                  .missing = {},
                                  .picture = {}};
    if (pair.measure.is_seen) {
      line.contradicted = pair.measure.contradicted;
      line.missing = pair.measure.missing;
    }
    if (picture_folder) {
      const auto path = *picture_folder / fmt::format("pair_{}_{}.png", line.from, line.to);
      line.picture = path.string();
      const auto written = timed(report, "export", [&] { return write_picture(inputs, alignment, pair, path); });
      if (!written) return written;
    }
    told.pairs.push_back(std::move(line));
  }
  return {};
}

Result<void> fuse_aligned(const AlignInputs& inputs, const Alignment& alignment, const Job& job, std::stop_token stop,
                          Console& console, RunReport& report) {
  if (job.outputs.trajectory) {
    if (auto written = write_poses(alignment, inputs.world, *job.outputs.trajectory, report); !written) return written;
  }
  auto volume = TsdfVolume::create(job.config.fusion);
  if (!volume) return volume.error();
  for (std::size_t i = 0; i < inputs.inputs.size(); ++i) {
    if (!inputs.inputs[i].is_fusable() || stop.stop_requested()) continue;
    console.progress("fusing", i + 1, inputs.inputs.size());
    if (auto fused = fuse_scan(inputs.inputs[i], inputs.models[i], alignment.T_world_scan[i], job, stop, console,
                               *volume, report);
        !fused)
      return fused;
  }
  if (stop.stop_requested()) {
    if (report.frames.fused == 0) return Error{ErrorCode::kTooLittle, "interrupted before anything was fused: no mesh"};
    console.warn("interrupted: the mesh holds only what was fused until then");
    report.warnings.emplace_back("interrupted: the mesh holds only what was fused until then");
  }
  report.volume.is_budget_reached = volume->is_budget_reached;
  if (volume->is_budget_reached) console.warn("the volume has reached fusion.memory_budget: the mesh is incomplete");
  describe_volume(*volume, report);
  if (job.outputs.volume) {
    report.files["volume"] = job.outputs.volume->string();
    if (auto saved = timed(report, "write", [&] { return volume->save(*job.outputs.volume); }); !saved) return saved;
  }
  const bool has_colours = std::any_of(inputs.inputs.begin(), inputs.inputs.end(), [](const AlignInput& input) {
    return input.kind == AlignKind::kRecording || !input.colours.empty();
  });
  report.extract.isovalue = job.config.extract.isovalue;
  report.extract.isovalue_source = "config";
  const std::size_t told = report.warnings.size();
  const FieldView view = has_colours ? volume->field_view() : volume->field_view().without_colours();
  const auto finished = finished_surface(view, job.config, inputs.inputs[0].world_up, report, stop);
  say_warnings(report, told, console);
  if (!finished) return finished.error();
  return write_surface(finished->surface, {inputs.inputs[0].world_up, std::nullopt, std::nullopt}, job, report);
}

Result<void> write_aligned_points(const AlignInputs& inputs, const Alignment& alignment,
                                  const std::filesystem::path& path, RunReport& report) {
  const bool has_colours = std::none_of(inputs.inputs.begin(), inputs.inputs.end(),
                                        [](const AlignInput& input) { return input.colours.empty(); });
  Mesh all;
  for (std::size_t i = 0; i < inputs.models.size(); ++i) {
    const OrientedPoints& points = inputs.models[i].all;
    const Pose& T = alignment.T_world_scan[i];
    for (std::size_t k = 0; k < points.size(); ++k) {
      all.positions_m.push_back((T * points.points_m[k].cast<double>()).cast<float>());
      all.normals.push_back((T.linear() * points.normals[k].cast<double>()).cast<float>());
      if (has_colours) all.colours.push_back(inputs.inputs[i].colours[k]);
    }
  }
  report.files["points"] = path.string();
  return timed(report, "write", [&] { return write_points(all, path); });
}

std::string alignment_text(const RunReport& report) {
  if (!report.alignment) return "";
  std::string text = "Pairs    scans   residual   overlap   in the way   missing   verdict\n";
  for (const auto& pair : report.alignment->pairs) {
    const auto share = [](const std::optional<double>& value) {
      return value ? fmt::format("{:.1f} %", 100 * *value) : "?";
    };
    text += fmt::format("         {:<7} {:>5.3f} mm {:>7.0f} % {:>11} {:>9}   {}{}{}\n",
                        fmt::format("{} {}", pair.from, pair.to), pair.residual_m * 1000, pair.overlap * 100,
                        share(pair.contradicted), share(pair.missing), pair.verdict, pair.reason.empty() ? "" : ": ",
                        pair.reason);
  }
  return text;
}

}  // namespace scanknit
