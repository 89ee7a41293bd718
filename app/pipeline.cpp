#include "app/pipeline.h"

#include "acquire/frame_source.h"
#include "app/budget_check.h"
#include "app/frame_intake.h"
#include "app/mesh_output.h"
#include "app/pace_control.h"
#include "app/pose_finder.h"
#include "app/reconstruction.h"
#include "app/scan_view.h"

namespace scanknit {
namespace {

/// The volume was full: what it holds is worth a mesh.
bool is_partial(const Error& tracking) {
  return tracking.code == ErrorCode::kBudget;
}

Result<void> fuse_frames(FrameIntake& intake, Reconstruction& scan, ScanView& view, RunReport& report) {
  while (!intake.is_over()) {
    if (auto frame = intake.next()) {
      const auto T_world_camera = scan.add(*frame);
      if (!T_world_camera) return T_world_camera.error();
      view.show(*frame, *T_world_camera, scan.volume(), report);
    } else {
      view.show_progress(scan.volume(), report);
    }
    view.obey(scan, intake, report);
  }
  auto usable = intake.result();
  if (usable) return usable;
  const auto tracked = check_tracking(report);  // says better why nothing was fused
  return tracked ? usable : tracked;
}

/// What there is beside the mesh.
Result<void> write_scan(Reconstruction& scan, RunReport& report) {
  describe_volume(scan.volume(), report);
  if (auto saved = scan.write_volume(); !saved) return saved;
  return scan.write_trajectory();
}

}  // namespace

Result<void> run_pipeline(const Job& job, std::stop_token stop, Console& console, RunReport& report, ScanView& view) {
  if (auto writable = check_outputs(job.outputs); !writable) return writable;
  auto opened = open_recording(job.input, job.config.acquire);
  if (!opened) return opened.error();
  for (const std::string& warning : (*opened)->info().warnings) console.warn(warning);
  const auto source = paced(*std::move(opened), job.pace, terminal_pace_control());
  if (auto fits = check_budget(job.input, source->info().poses, job.config, stop); !fits) return fits;
  if (auto opened_view = view.open(source->info().world_up); !opened_view) return opened_view;
  const SecondLook again{[&] { return open_recording(job.input, job.config.acquire); }, stop};
  return mesh_source(*source, job, stop, console, report, view, again);
}

Result<void> mesh_source(FrameSource& source, const Job& job, std::stop_token stop, Console& console, RunReport& report,
                         ScanView& view, const SecondLook& again) {
  warn_of_holes(job.config.extract, console);
  FrameIntake intake(source, job.config.acquire, stop, console, report);
  auto scan = Reconstruction::create(job, source.info(), intake, report);
  if (!scan) return scan.error();
  if (auto begun = view.begin(scan->volume(), source.info()); !begun) return begun;

  if (auto fused = fuse_frames(intake, *scan, view, report); !fused) return fused;
  view.show_writing();
  if (auto saved = write_scan(*scan, report); !saved) return saved;
  const auto tracked = check_tracking(report);
  if (!tracked && !is_partial(tracked.error())) return tracked;
  if (const auto warning = tracking_warning(report)) {
    console.warn(*warning);
    report.warnings.push_back(*warning);
  }
  const std::size_t warnings_before = report.warnings.size();
  auto meshed = scan->write_mesh(report, EmptyCrop::kIgnored);
  for (std::size_t i = warnings_before; i < report.warnings.size(); ++i) console.warn(report.warnings[i]);
  view.show_all(scan->volume());
  if (!meshed || !tracked || again.stop.stop_requested()) return meshed ? tracked : meshed;
  if (!look_again(*scan, again, console, report)) return {};
  view.show_anew(scan->volume());
  if (auto saved = write_scan(*scan, report); !saved) return saved;
  return scan->write_mesh(report, EmptyCrop::kIgnored);
}

}  // namespace scanknit
