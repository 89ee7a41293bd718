#include "app/scan/pipeline.h"

#include <fmt/format.h>

#include <memory>
#include <set>
#include <utility>

#include "acquire/convert/cut_recording.h"
#include "acquire/frame_source.h"
#include "app/live/scan_view.h"
#include "app/scan/budget_check.h"
#include "app/scan/finish_surface.h"
#include "app/scan/frame_intake.h"
#include "app/scan/mesh_output.h"
#include "app/scan/only_frames.h"
#include "app/scan/pose_finder.h"
#include "app/scan/reconstruction.h"
#include "app/scan/texture_output.h"
#include "app/scan/turntable_scan.h"
#include "app/terminal/pace_control.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

void warn(const std::string& text, Console& console, RunReport& report) {
  console.warn(text);
  report.warnings.push_back(text);
}

void add_samples(const StageTimes& from, StageTimes& to) {
  to.samples_ms.insert(to.samples_ms.end(), from.samples_ms.begin(), from.samples_ms.end());
}

/// But for what was never to be of the mesh.
void forget_frames(const RunReport::Frames& left_out, RunReport& report) {
  report.frames = left_out;
  report.tracking.reset();
  report.volume = {};
  report.mesh.reset();
  report.holes.reset();
  report.fit.reset();
  forget_finish(report);
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
      view.show_progress(intake, scan.volume(), report);
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

/// What its finishing warns of is said, too, unless it was said of the mesh before that one.
Result<WrittenMesh> write_mesh(const Reconstruction& scan, Console& console, RunReport& report) {
  const std::set<std::string> said(report.warnings.begin(), report.warnings.end());
  forget_finish(report);
  const std::size_t warnings_before = report.warnings.size();
  auto meshed = scan.write_mesh(report, EmptyCrop::kIgnored);
  for (std::size_t i = warnings_before; i < report.warnings.size(); ++i) {
    if (!said.contains(report.warnings[i])) console.warn(report.warnings[i]);
  }
  return meshed;
}

/// The scan has changed: all of it is written anew.
Result<WrittenMesh> write_anew(Reconstruction& scan, Console& console, RunReport& report) {
  if (auto saved = write_scan(scan, report); !saved) return saved.error();
  return write_mesh(scan, console, report);
}

Result<void> write_and_texture(Reconstruction& scan, const Job& job, std::stop_token stop, Console& console,
                               RunReport& report) {
  const auto written = write_anew(scan, console, report);
  if (!written) return written.error();
  const SecondLook again{[&] { return open_frames(job); }, stop};
  return write_textured(*written, job, again, console, report);
}

/// The end of a scan, when all of it is known. True: it has changed.
Result<bool> improve(Reconstruction& scan, FrameIntake& intake, const SecondLook& again, Console& console,
                     RunReport& report, TurntableScan* table) {
  if (table != nullptr) return table->refine(scan, intake);
  return look_again(scan, again, console, report);
}

/// What stands still is known before the frames are tracked. If it turns out that this is no turntable, the recording
/// is meshed as any other.
Result<void> mesh_turntable(FrameIntake& intake, const Job& job, Console& console, RunReport& report, ScanView& view,
                            const SecondLook& again) {
  TurntableScan table(job, intake.info().poses, again.stop, console, report);
  if (auto learned = table.learn(); !learned) return learned;
  Job turning = job;
  turning.config.fusion.loop_closure = false;  // the turn closes otherwise
  const auto meshed = mesh_frames(intake, turning, console, report, view, again, &table);
  table.conclude(/*has_mesh=*/meshed.has_value());
  if (!meshed) return meshed;  // all of each picture would be of what stands still
  const bool was_as_any = !table.changes_frames() && !(job.config.fusion.loop_closure && report.tracking);
  if (report.turntable->is_refined || was_as_any || again.stop.stop_requested()) return meshed;
  Job same = job;
  same.frames = intake.taken();
  const auto frames = open_frames(same);
  if (!frames) return frames.error();
  forget_frames(intake.left_out(), report);
  FrameIntake once_more(**frames, job.config.acquire, again.stop, console, report);
  return mesh_frames(once_more, job, console, report, view, again);
}

/// What only a turntable takes.
Result<void> check_is_turntable(const Job& job) {
  if (!job.cut_recording && !job.angles) return {};
  if (job.config.turntable.is_enabled && job.config.acquire.poses != PoseMode::kStill) return {};
  return Error{ErrorCode::kUsage, fmt::format("{} is for turntables: give --preset turntable, and no --poses still",
                                              job.cut_recording ? "--cut-recording" : "--angles")};
}

/// One spelling of a path, whether or not it is there.
fs::path settled(const fs::path& path) {
  std::error_code code;
  const fs::path whole = fs::weakly_canonical(fs::absolute(path, code), code);
  return whole.has_filename() ? whole : whole.parent_path();
}

/// Before any work: it is not there yet, or empty, and not where other things are or will be.
Result<void> check_cut_recording(const Job& job) {
  if (!job.cut_recording) return {};
  const fs::path folder = settled(*job.cut_recording);
  const fs::path input = settled(job.input);
  for (fs::path at = folder; at != at.parent_path(); at = at.parent_path()) {
    if (at == input) {
      return Error{ErrorCode::kOutput, "lies in the recording itself; give another --cut-recording", folder.string()};
    }
  }
  for (const fs::path& mesh : job.outputs.meshes) {
    if (settled(mesh).parent_path() == folder) {
      return Error{ErrorCode::kOutput,
                   "is where the mesh goes; give another --cut-recording, for example its folder turn",
                   folder.string()};
    }
  }
  return CutRecording::check(*job.cut_recording);
}

}  // namespace

Result<std::unique_ptr<FrameSource>> open_frames(const Job& job, std::size_t every) {
  AcquireConfig config = job.config.acquire;
  config.every *= every;
  auto source = open_recording(job.input, config);
  if (!source || !job.frames) return source;
  return std::unique_ptr<FrameSource>(std::make_unique<OnlyFrames>(*std::move(source), *job.frames));
}

Result<void> run_pipeline(const Job& job, std::stop_token stop, Console& console, RunReport& report, ScanView& view) {
  if (auto writable = check_outputs(job.outputs); !writable) return writable;
  if (auto asked = check_is_turntable(job); !asked) return asked;
  if (auto place = check_cut_recording(job); !place) return place;
  auto opened = open_recording(job.input, job.config.acquire);
  if (!opened) return opened.error();
  for (const std::string& warning : (*opened)->info().warnings) warn(warning, console, report);
  const auto source = paced(*std::move(opened), job.pace, terminal_pace_control());
  if (auto fits = check_budget(job.input, source->info().poses, job.config, stop); !fits) return fits;
  if (auto opened_view = view.open(source->info().world_up); !opened_view) return opened_view;
  const SecondLook again{[&] { return open_frames(job); }, stop};
  const bool stands_still = source->info().poses == PoseMode::kStill;
  FrameIntake intake(*source, job.config.acquire, stop, console, report);
  if (job.config.turntable.is_enabled && !stands_still) {
    return mesh_turntable(intake, job, console, report, view, again);
  }
  if (job.config.turntable.is_enabled) {
    warn("--poses still: nothing is taken to turn, and no turntable is looked for", console, report);
  }
  return mesh_frames(intake, job, console, report, view, again);
}

Result<void> mesh_frames(FrameIntake& intake, const Job& job, Console& console, RunReport& report, ScanView& view,
                         const SecondLook& again, TurntableScan* table) {
  warn_of_holes(job.config.extract, console);
  auto scan = Reconstruction::create(job, intake.info(), intake, report);
  if (!scan) return scan.error();
  if (table != nullptr) scan->edit_frames([table](Frame& frame) { table->clear_still(frame); });
  scan->crop(view.crop_in_force());
  if (auto begun = view.begin(scan->volume(), intake.info()); !begun) return begun;

  if (auto fused = fuse_frames(intake, *scan, view, report); !fused) return fused;
  view.show_writing();
  if (auto saved = write_scan(*scan, report); !saved) return saved;
  const auto tracked = check_tracking(report);
  const bool is_lost = !tracked && !is_partial(tracked.error());
  const auto lost = tracking_warning(report);
  std::optional<WrittenMesh> mesh;
  const auto write_tracked = [&]() -> Result<void> {
    auto meshed = write_mesh(*scan, console, report);
    view.show_result(*scan, intake, report);
    if (!meshed) return meshed.error();
    mesh = *std::move(meshed);
    return {};
  };
  if (!is_lost) {
    if (auto written = write_tracked(); !written) return written;
    if (!tracked) return tracked;
  }
  const bool may_improve = !again.stop.stop_requested() && (!is_lost || table != nullptr);
  const auto improved = may_improve ? improve(*scan, intake, again, console, report, table) : Result<bool>(false);
  if (!improved) return improved.error();
  if (is_lost && !*improved && !again.stop.stop_requested()) return tracked;
  if (lost && !(*improved && table != nullptr)) warn(*lost, console, report);  // a turntable may have fused them yet
  if (*improved) {
    view.show_anew(*scan, intake, report);
    auto anew = write_anew(*scan, console, report);
    if (!anew) return anew.error();
    mesh = *std::move(anew);
  } else if (!mesh) {  // interrupted: what there is is better than nothing
    if (auto written = write_tracked(); !written) return written;
  }
  return write_textured(*mesh, job, again, console, report);
}

Result<bool> mesh_recorded_turntable(const Job& job, const RunReport::Frames& left_out, std::stop_token stop,
                                     Console& console, RunReport& report, ScanView& view) {
  auto source = open_frames(job);
  if (!source) return source.error();
  RunReport again;
  again.frames = left_out;
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
  scan->crop(view.crop_in_force());
  const auto refined = table.refine(*scan, intake);
  report.turntable = again.turntable;
  const bool is_refined = refined && *refined;
  if (is_refined) view.show_anew(*scan, intake, again);
  const auto written = is_refined ? write_and_texture(*scan, job, stop, console, again) : Result<void>();
  if (is_refined) forget_finish(report);
  report.warnings.insert(report.warnings.end(), again.warnings.begin(), again.warnings.end());
  for (const char* stage : {"refine", "fuse_again", "view_all", "extract", "finish", "export", "texture", "write"}) {
    const auto times = again.stages.find(stage);
    if (times != again.stages.end()) add_samples(times->second, report.stages[stage]);
  }
  if (!is_refined) return refined;
  if (!written) return written.error();
  report.finish = again.finish;
  report.frames = again.frames;
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
