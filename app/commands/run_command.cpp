#include <chrono>

#include "app/commands/commands.h"
#include "app/live/scan_view.h"
#include "app/scan/pipeline.h"
#include "app/scan/run_report.h"
#include "app/terminal/signals.h"

namespace scanknit {

int run_command(const RunArguments& arguments, const CommonArguments& common) {
  const StopOnSignal stop_on_signal;  // before any other thread
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

  const Job job{arguments.recording, std::move(loaded->config), *outputs,
                arguments.pace,      arguments.angles,          arguments.cut_recording};
  RunReport report = begin_report(job);
  Console console(common.verbosity);
  warn_of_unused_options(job, console, report);
  ScanView view(arguments.view, job, "run", stop_on_signal.token(), console);
  const Result<void> result = run_pipeline(job, stop_on_signal.token(), console, report, view);
  close_report(report, result, stop_on_signal.token().stop_requested(), begin);
  const int exit_code = conclude(report, result, job, common);
  view.linger(report);
  return exit_code;
}

}  // namespace scanknit
