// capture: from a scanner that is plugged in to a mesh, with the recording beside it.
#include <fmt/format.h>

#include <chrono>
#include <utility>

#include "app/commands/commands.h"
#include "app/live/scan_view.h"
#include "app/scan/frame_intake.h"
#include "app/scan/live_scanner.h"
#include "app/scan/pipeline.h"
#include "app/scan/run_report.h"
#include "app/terminal/signals.h"
#include "core/files/atomic_file.h"

namespace scanknit {
namespace {

/// Beside the mesh: OUT/recording.mcap, or NAME.mcap for one mesh file.
std::filesystem::path default_recording(const std::filesystem::path& output, const Outputs& outputs) {
  const bool is_one_file = !outputs.meshes.empty() && outputs.meshes.front() == output;
  return is_one_file ? std::filesystem::path(output).replace_extension(".mcap") : output / "recording.mcap";
}

Result<std::unique_ptr<Recorder>> open_recorder(const CaptureArguments& arguments, const Outputs& outputs,
                                                const RawCalibration& calibration, Console& console,
                                                RunReport& report) {
  if (!arguments.wants_recording) return std::unique_ptr<Recorder>();
  const auto path = arguments.recording.value_or(default_recording(arguments.outputs.output, outputs));
  if (auto writable = check_writable(path); !writable) return writable.error();
  auto recorder = Recorder::create(path, calibration);
  if (!recorder) return recorder.error();
  console.info(fmt::format("recording to {}", path.string()));
  report.files["recording"] = path.string();
  return recorder;
}

/// The scanner gave up: that is told together with what came of the pictures until then.
Error result_of_failed_scan(const Error& failure, const Result<void>& meshed) {
  if (meshed) {
    return {ErrorCode::kDevice, fmt::format("{}; what was scanned until then has been meshed", failure.message)};
  }
  // Without a picture there is nothing else to blame.
  const ErrorCode code = meshed.error().code == ErrorCode::kInput ? ErrorCode::kDevice : meshed.error().code;
  return {code, fmt::format("{}; of what was scanned until then: {}", failure.message, meshed.error().text())};
}

/// The mesh of the scan is safe on disk; that of the refined turntable takes its place. A second Ctrl-C leaves it
/// there.
Result<void> refine_turntable(const Job& scanned, const FrameIntake& intake, const Result<void>& meshed,
                              Console& console, RunReport& report, ScanView& view) {
  const auto recording = report.files.find("recording");
  if (!scanned.config.turntable.is_enabled || scanned.config.acquire.poses == PoseMode::kStill) return meshed;
  if (recording == report.files.end()) {
    console.warn("turntable: without a recording the mesh is the tracked one");
    return meshed;
  }
  Job job = scanned;
  job.input = recording->second;
  job.frames = intake.taken();
  console.info("finding the axis and the angles of the turntable; Ctrl-C leaves the mesh as it is");
  const auto refined = mesh_recorded_turntable(job, intake.left_out(), /*stop=*/{}, console, report, view);
  if (refined && *refined) return {};
  if (!refined) console.warn(fmt::format("turntable: {}; the mesh is the tracked one", refined.error().text()));
  return meshed;
}

Result<void> capture(const CaptureArguments& arguments, const Job& job, std::stop_token stop, Console& console,
                     RunReport& report, ScanView& view) {
  const PoseMode poses = job.config.acquire.poses;
  if (poses == PoseMode::kRecording || poses == PoseMode::kRefine) {
    return Error{ErrorCode::kUsage, "a scanner knows no poses: --poses track (the default) or still"};
  }
  if (job.config.output.texture != TextureFormat::kOff && !arguments.wants_recording) {
    return Error{ErrorCode::kUsage,
                 "export.texture is baked from the recording: leave out --no-recording, or leave the texture off"};
  }
  if (auto writable = check_outputs(job.outputs); !writable) return writable;
  const Warn warn = [&](const std::string& text) {
    console.warn(text);
    report.warnings.push_back(text);
  };
  if (auto opened = view.open(UpAxis::kMinusY); !opened) return opened;
  auto scanner = open_scanner(arguments.scanner, job.config, Calibration::kNeeded, stop, console, warn);
  if (!scanner) return scanner.error();
  report.input = scanner->device->info().uri;
  auto recorder = open_recorder(arguments, job.outputs, scanner->calibration, console, report);
  if (!recorder) return recorder.error();
  const PoseMode settled = poses == PoseMode::kStill ? PoseMode::kStill : PoseMode::kTrack;
  LiveOptions options = live_options(arguments.scanner, settled, warn);
  bool is_told_of_recorder = false;
  options.on_recorder_failure = [&](const Error& error) {
    warn(error.text() + "; the scan goes on");
    is_told_of_recorder = true;
  };
  auto source = LiveSource::start(*std::move(scanner), std::move(options), recorder->get());
  if (!source) {
    report.files.erase("recording");  // without a picture it is not kept
    return source.error();
  }
  console.info("scanning; Ctrl-C ends the scan and makes the mesh");

  bool is_recording = *recorder != nullptr;
  const auto finish_recording = [&] {
    if (!std::exchange(is_recording, false)) return;
    const auto kept = (*recorder)->finish();
    if (!kept && !is_told_of_recorder) warn(kept.error().text());
    if (kept && kept->frames == 0) report.files.erase("recording");
  };
  SecondLook again;  // Ctrl-C ends the scan, not what comes after it; a second one ends the program
  if (is_recording) {
    again.open = [&, recording = report.files["recording"]] {
      finish_recording();
      return open_recording(recording, job.config.acquire);
    };
  }
  const auto losses_so_far = [&] {
    LossCounters losses = (*source)->losses();
    if (*recorder != nullptr) losses.writer += (*recorder)->lost();
    return losses;
  };
  view.watch_losses(losses_so_far);
  FrameIntake intake(**source, job.config.acquire, stop, console, report);
  Result<void> meshed = mesh_frames(intake, job, console, report, view, again);
  view.watch_losses(nullptr);
  finish_recording();
  const LossCounters losses = losses_so_far();
  report.losses = named(losses);
  warn_of_losses(losses, console);
  meshed = refine_turntable(job, intake, meshed, console, report, view);
  return (*source)->failure() ? result_of_failed_scan(*(*source)->failure(), meshed) : meshed;
}

}  // namespace

int capture_command(const CaptureArguments& arguments, const CommonArguments& common) {
  const StopOnSignal stop_on_signal;  // before any other thread
  const auto begin = std::chrono::steady_clock::now();
  auto loaded = load_config(with_run_defaults(common.config));
  if (!loaded) return fail(loaded.error(), common);
  auto outputs = plan_outputs(arguments.outputs, loaded->config.output);
  if (!outputs) return fail(outputs.error(), common);
  if (arguments.view.is_wanted) add_downloads(*outputs);

  const Job job{arguments.scanner.device, std::move(loaded->config), *outputs};
  RunReport report = begin_report(job);
  Console console(common.verbosity);
  warn_of_unused_options(job, console, report);
  ScanView view(arguments.view, job, "capture", stop_on_signal.token(), console);
  const Result<void> result = capture(arguments, job, stop_on_signal.token(), console, report, view);
  close_report(report, result, /*was_interrupted=*/false, begin);  // Ctrl-C is how a scan ends
  const int exit_code = conclude(report, result, job, common);
  view.linger(report);
  return exit_code;
}

}  // namespace scanknit
