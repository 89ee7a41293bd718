#include "app/pipeline.h"

#include <fmt/format.h>

#include "acquire/depth_filter.h"
#include "acquire/frame_source.h"
#include "app/budget_check.h"
#include "app/frame_intake.h"
#include "app/mesh_output.h"
#include "app/pace_control.h"
#include "app/pose_finder.h"
#include "app/stage_timer.h"
#include "core/atomic_file.h"
#include "extract/extract_surface.h"
#include "fusion/integrate.h"
#include "fusion/tsdf_volume.h"

namespace scanknit {
namespace {

FieldView field_view(const TsdfVolume& volume) {
  FieldView view;
  view.field = &volume.tsdf();
  view.weight_codes = &volume.weight();
  view.colour_codes = &volume.colour();
  return view;
}

/// The volume was full: what it holds is worth a mesh.
bool is_partial(const Error& tracking) {
  return tracking.code == ErrorCode::kBudget;
}

Result<void> fuse_frames(FrameIntake& intake, PoseFinder poses, const Config& config, TsdfVolume& volume,
                         RunReport& report) {
  while (auto frame = intake.next()) {
    timed(report, "filter", [&] { filter_frame(*frame, config.acquire, config.fusion.noise); });
    const auto T_world_camera = poses.find(*frame, volume, report);
    if (!T_world_camera) continue;
    const auto fused = timed(report, "integrate", [&] { return integrate(*frame, *T_world_camera, volume); });
    if (!fused && fused.error().code == ErrorCode::kInput) {
      intake.note_refused(*frame, fused.error());
      continue;
    }
    if (!fused) return fused.error();
    intake.note_fused(*frame, *T_world_camera, fused->is_budget_reached);
  }
  auto usable = intake.result();
  if (usable) return usable;
  const auto tracked = check_tracking(report);  // says better why nothing was fused
  return tracked ? usable : tracked;
}

Result<void> save_volume(const TsdfVolume& volume, const Outputs& outputs, RunReport& report) {
  if (!outputs.volume) return {};
  report.files["volume"] = outputs.volume->string();
  return timed(report, "write", [&] { return volume.save(*outputs.volume); });
}

Result<void> save_trajectory(const FrameIntake& intake, const Outputs& outputs, RunReport& report) {
  if (!outputs.trajectory) return {};
  report.files["trajectory"] = outputs.trajectory->string();
  const std::string text = to_tum_trajectory(intake.trajectory());
  return timed(report, "write", [&] { return write_file_atomically(*outputs.trajectory, text); });
}

/// With where the scanner stood half way through the scan.
MeshFrame mesh_frame(const RecordingInfo& info, const FrameIntake& intake) {
  return {info.world_up, intake.trajectory()[intake.trajectory().size() / 2].T_world_camera, std::nullopt};
}

Result<void> mesh_volume(const FieldView& view, const MeshFrame& frame, const Job& job, RunReport& report) {
  report.extract.isovalue = job.config.extract.isovalue;
  report.extract.isovalue_source = "config";
  const auto surface = timed(report, "extract", [&] { return extract_surface(view, job.config.extract); });
  if (!surface) return surface.error();
  return write_surface(*surface, frame, job, report);
}

}  // namespace

Result<void> run_pipeline(const Job& job, std::stop_token stop, Console& console, RunReport& report) {
  if (auto writable = check_outputs(job.outputs); !writable) return writable;
  auto opened = open_recording(job.input, job.config.acquire);
  if (!opened) return opened.error();
  for (const std::string& warning : (*opened)->info().warnings) console.warn(warning);
  const auto source = paced(*std::move(opened), job.pace, terminal_pace_control());
  if (auto fits = check_budget(job.input, source->info().poses, job.config, stop); !fits) return fits;
  return mesh_source(*source, job, stop, console, report);
}

Result<void> mesh_source(FrameSource& source, const Job& job, std::stop_token stop, Console& console,
                         RunReport& report) {
  warn_of_holes(job.config.extract, console);
  auto volume = TsdfVolume::create(job.config.fusion);
  if (!volume) return volume.error();

  FrameIntake intake(source, job.config.acquire, stop, console, report);
  if (auto fused = fuse_frames(intake, PoseFinder(source.info().poses), job.config, *volume, report); !fused)
    return fused;
  describe_volume(*volume, report);
  if (auto saved = save_volume(*volume, job.outputs, report); !saved) return saved;
  if (auto saved = save_trajectory(intake, job.outputs, report); !saved) return saved;
  const auto tracked = check_tracking(report);
  if (!tracked && !is_partial(tracked.error())) return tracked;
  if (const auto warning = tracking_warning(report)) {
    console.warn(*warning);
    report.warnings.push_back(*warning);
  }
  auto meshed = mesh_volume(field_view(*volume), mesh_frame(source.info(), intake), job, report);
  return meshed ? tracked : meshed;
}

}  // namespace scanknit
