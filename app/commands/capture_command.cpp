// capture: scans with a scanner that is plugged in, and writes a mesh and a recording.
#include <chrono>
#include <utility>

#include "app/commands.h"
#include "app/live/scan_view.h"
#include "app/report/conclude.h"
#include "app/terminal/signals.h"
#include "scan/scan.h"
#include "scan/stage_times.h"

namespace scanknit {
namespace {

/// The recording next to the mesh: OUT/recording.mcap, or NAME.mcap for one mesh file.
std::filesystem::path default_recording(const std::filesystem::path& output, const Outputs& outputs) {
  const auto& meshes = outputs.scan.meshes;
  const bool is_one_file = !meshes.empty() && meshes.front() == output;
  return is_one_file ? std::filesystem::path(output).replace_extension(".mcap") : output / "recording.mcap";
}

}  // namespace

int capture_command(const CaptureArguments& arguments, const CommonArguments& common) {
  const StopOnSignal stop_on_signal;  // must come before any other thread
  const auto begin = std::chrono::steady_clock::now();
  auto loaded = load_config(with_run_defaults(common.config));
  if (!loaded) return fail(loaded.error(), common);
  auto outputs = plan_outputs(arguments.outputs, loaded->config.output);
  if (!outputs) return fail(outputs.error(), common);
  LiveScanRequest request{arguments.scanner, std::nullopt};
  if (arguments.wants_recording) {
    request.recording = arguments.recording.value_or(default_recording(arguments.outputs.output, *outputs));
  }
  if (arguments.view.is_wanted) add_downloads(*outputs);

  const ScanJob job = job_of(arguments.scanner.device, loaded->config, *outputs);
  Console console(common.verbosity);
  ScanView view(arguments.view, job, ScanView::Mode::kCapture, stop_on_signal.token(), console);
  ScanResult scan = scan_live(job, request, view, stop_on_signal.token());
  add_times(view.times(), scan.stages);
  CommandRun run = close_run(std::move(scan), /*was_interrupted=*/false, begin);  // Ctrl-C is the normal end of a scan
  const int exit_code = conclude(run, *outputs, common);
  view.serve_result(run);
  return exit_code;
}

}  // namespace scanknit
