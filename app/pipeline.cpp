#include "app/pipeline.h"

#include "acquire/convert/cut_recording.h"
#include "acquire/frame_source.h"
#include "app/budget_check.h"
#include "app/frame_intake.h"
#include "app/mesh_output.h"
#include "app/pace_control.h"
#include "app/pose_finder.h"
#include "app/reconstruction.h"
#include "app/scan_view.h"
#include "app/texture_output.h"
#include "app/turntable_scan.h"

namespace scanknit {
namespace {

/// The frames are read from the beginning again.
void forget_frames(RunReport& report) {
  report.frames = {};
  report.tracking.reset();
  report.volume = {};
  report.mesh.reset();
  report.holes.reset();
  report.fit.reset();
  report.texture.reset();
}

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

/// The scan has changed: all of it is written anew.
Result<WrittenMesh> write_anew(Reconstruction& scan, RunReport& report) {
  if (auto saved = write_scan(scan, report); !saved) return saved.error();
  return scan.write_mesh(report, EmptyCrop::kIgnored);
}

/// The end of a scan, when all of it is known. True: it has changed.
Result<bool> improve(Reconstruction& scan, FrameIntake& intake, const SecondLook& again, Console& console,
                     RunReport& report, TurntableScan* table) {
  if (table != nullptr) return table->refine(scan, intake);
  return look_again(scan, again, console, report);
}

/// What stands still is known before the frames are tracked. If it turns out that this is no turntable, the recording
/// is meshed as any other.
Result<void> mesh_turntable(FrameSource& source, const Job& job, Console& console, RunReport& report, ScanView& view,
                            const SecondLook& again) {
  TurntableScan table(job, source.info().poses, again.stop, console, report);
  if (auto learned = table.learn(); !learned) return learned;
  Job turning = job;
  turning.config.fusion.loop_closure = false;  // the turn closes otherwise
  const auto meshed = mesh_source(source, turning, again.stop, console, report, view, again, &table);
  if (!meshed && meshed.error().code == ErrorCode::kConfig) return meshed;  // what is known of the angles is wrong
  table.conclude();
  const bool was_as_any = !table.changes_frames() && !(job.config.fusion.loop_closure && report.tracking);
  if (report.turntable->is_refined || was_as_any || again.stop.stop_requested()) return meshed;
  auto whole = again.open();
  if (!whole) return whole.error();
  forget_frames(report);
  return mesh_source(**whole, job, again.stop, console, report, view, again);
}

}  // namespace

Result<void> run_pipeline(const Job& job, std::stop_token stop, Console& console, RunReport& report, ScanView& view) {
  if (auto writable = check_outputs(job.outputs); !writable) return writable;
  if (job.cut_recording) {
    if (auto writable = CutRecording::check(*job.cut_recording); !writable) return writable;
  }
  auto opened = open_recording(job.input, job.config.acquire);
  if (!opened) return opened.error();
  for (const std::string& warning : (*opened)->info().warnings) console.warn(warning);
  const auto source = paced(*std::move(opened), job.pace, terminal_pace_control());
  if (auto fits = check_budget(job.input, source->info().poses, job.config, stop); !fits) return fits;
  if (auto opened_view = view.open(source->info().world_up); !opened_view) return opened_view;
  const SecondLook again{[&] { return open_recording(job.input, job.config.acquire); }, stop};
  if (job.config.turntable.is_enabled && source->info().poses != PoseMode::kStill) {
    return mesh_turntable(*source, job, console, report, view, again);
  }
  return mesh_source(*source, job, stop, console, report, view, again);
}

Result<void> mesh_source(FrameSource& source, const Job& job, std::stop_token stop, Console& console, RunReport& report,
                         ScanView& view, const SecondLook& again, TurntableScan* table) {
  warn_of_holes(job.config.extract, console);
  FrameIntake intake(source, job.config.acquire, stop, console, report);
  auto scan = Reconstruction::create(job, source.info(), intake, report);
  if (!scan) return scan.error();
  if (table != nullptr) scan->edit_frames([table](Frame& frame) { table->clear_still(frame); });
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
  view.show_all(scan->volume(), report);
  if (!meshed) return meshed.error();
  if (!tracked) return tracked;
  const auto is_better = again.stop.stop_requested() ? false : improve(*scan, intake, again, console, report, table);
  if (!is_better) return is_better.error();
  if (*is_better) {
    view.show_anew(scan->volume(), report);
    meshed = write_anew(*scan, report);
    if (!meshed) return meshed.error();
  }
  return write_textured(*meshed, job, again, console, report);
}

Result<bool> mesh_recorded_turntable(const Job& job, std::stop_token stop, Console& console, RunReport& report) {
  auto source = open_recording(job.input, job.config.acquire);
  if (!source) return source.error();
  RunReport again;
  TurntableScan table(job, (*source)->info().poses, stop, console, again);
  if (auto learned = table.learn(); !learned) return learned.error();
  FrameIntake intake(**source, job.config.acquire, stop, console, again);
  auto scan = Reconstruction::create(job, (*source)->info(), intake, again);
  if (!scan) return scan.error();
  scan->edit_frames([&table](Frame& frame) { table.clear_still(frame); });
  while (!intake.is_over()) {
    auto frame = intake.next();
    if (!frame) continue;
    if (const auto added = scan->add(*frame); !added) return added.error();
  }
  const auto refined = table.refine(*scan, intake);
  report.turntable = again.turntable;
  for (const char* stage : {"refine", "fuse_again"}) report.stages[stage] = again.stages[stage];
  if (!refined || !*refined) return refined;
  report.frames.fused = again.frames.fused;
  const auto written = write_anew(*scan, again);
  if (!written) return written.error();
  const SecondLook once_more{[&] { return open_recording(job.input, job.config.acquire); }, stop};
  if (auto textured = write_textured(*written, job, once_more, console, again); !textured) return textured.error();
  report.mesh = again.mesh;
  report.holes = again.holes;
  report.fit = again.fit;
  report.texture = again.texture;
  report.extract = again.extract;
  report.volume = again.volume;
  report.tracking = again.tracking;
  for (const auto& [kind, path] : again.files) report.files[kind] = path;
  return true;
}

}  // namespace scanknit
