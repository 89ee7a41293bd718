#include <chrono>
#include <utility>

#include "app/commands.h"
#include "app/live/scan_view.h"
#include "app/report/conclude.h"
#include "app/terminal/pace_control.h"
#include "app/terminal/signals.h"
#include "scan/scan.h"
#include "scan/stage_times.h"

namespace scanknit {

int run_command(const RunArguments& arguments, const CommonArguments& common) {
  const StopOnSignal stop_on_signal;  // must come before any other thread
  const auto begin = std::chrono::steady_clock::now();
  auto loaded = load_config(with_run_defaults(common.config));
  if (!loaded) return fail(loaded.error(), common);
  AcquireConfig& acquire = loaded->config.acquire;
  acquire.from = arguments.from;
  acquire.every = arguments.every;
  if (arguments.to) acquire.to = *arguments.to;
  auto outputs = plan_outputs(arguments.outputs, loaded->config.output);
  if (!outputs) return fail(outputs.error(), common);
  if (arguments.view.is_wanted) add_downloads(*outputs);

  ScanJob job = job_of(arguments.recording, loaded->config, *outputs);
  job.pace = arguments.pace;
  job.pace_control = terminal_pace_control;
  job.angles = arguments.angles;
  job.cut_recording = arguments.cut_recording;
  Console console(common.verbosity);
  ScanView view(arguments.view, job, ScanView::Mode::kRun, stop_on_signal.token(), console);
  ScanResult scan = scan_recording(job, view, stop_on_signal.token());
  add_times(view.times(), scan.stages);
  CommandRun run = close_run(std::move(scan), stop_on_signal.token().stop_requested(), begin);
  const int exit_code = conclude(run, *outputs, common);
  view.serve_result(run);
  return exit_code;
}

}  // namespace scanknit
