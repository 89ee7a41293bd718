#include "app/commands/mesh_command.h"

#include <chrono>
#include <utility>

#include "app/live/scan_view.h"
#include "app/report/conclude.h"
#include "app/terminal/pace_control.h"
#include "app/terminal/signals.h"
#include "scan/stage_times.h"

namespace scanknit {

int run_mesh_command(const MeshCommand& command, const CommonArguments& common) {
  const StopOnSignal stop_on_signal;  // must come before any other thread
  const std::stop_token stop = stop_on_signal.token();
  const auto begin = std::chrono::steady_clock::now();
  auto loaded = load_config(command.config);
  if (!loaded) return fail(loaded.error(), common);
  if (const auto usable = command.configure(loaded->config); !usable) return fail(usable.error(), common);
  auto outputs = plan_outputs(command.outputs, loaded->config.output);
  if (!outputs) return fail(outputs.error(), common);
  if (command.view.is_wanted) add_downloads(*outputs);

  ScanJob job = job_of(command.input, *loaded, *outputs);
  job.pace_control = terminal_pace_control;
  command.complete(job);
  Console console(common.verbosity);
  ScanView view(command.view, job, command.is_capture ? ScanView::Mode::kCapture : ScanView::Mode::kRun, stop, console);
  ScanResult scan = command.scan(job, *loaded, view, stop);
  add_times(view.times(), scan.stages);
  const bool was_interrupted = stop.stop_requested() && !command.is_capture;
  CommandRun run = close_run(std::move(scan), was_interrupted, begin);
  const int exit_code = conclude(run, *outputs, common, command.has_case_table);
  view.serve_result(run);
  return exit_code;
}

int run_command(const RunArguments& arguments, const CommonArguments& common) {
  return run_mesh_command(mesh_command_of(arguments, common.config), common);
}

int capture_command(const CaptureArguments& arguments, const CommonArguments& common) {
  return run_mesh_command(mesh_command_of(arguments, common.config), common);
}

int extract_command(const ExtractArguments& arguments, const CommonArguments& common) {
  return run_mesh_command(mesh_command_of(arguments, common.config), common);
}

int align_command(const AlignArguments& arguments, const CommonArguments& common) {
  return run_mesh_command(mesh_command_of(arguments, common.config), common);
}

}  // namespace scanknit
