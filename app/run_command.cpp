#include <chrono>

#include "app/commands.h"
#include "app/pipeline.h"
#include "app/run_report.h"
#include "app/signals.h"

namespace scanknit {

int run_command(const RunArguments& arguments, const CommonArguments& common) {
  const StopOnSignal stop_on_signal;  // before any other thread
  const auto begin = std::chrono::steady_clock::now();
  auto config = load_config(with_run_defaults(common.config));
  if (!config) return fail(config.error(), common);
  config->acquire.from = arguments.from;
  config->acquire.every = arguments.every;
  if (arguments.to) config->acquire.to = *arguments.to;
  const auto outputs = plan_outputs({.output = arguments.output,
                                     .report = arguments.report,
                                     .trajectory = arguments.trajectory,
                                     .volume = arguments.volume},
                                    config->output);
  if (!outputs) return fail(outputs.error(), common);

  const Job job{arguments.recording, std::move(*config), *outputs, arguments.pace};
  RunReport report = begin_report(job);
  Console console(common.verbosity);
  const Result<void> result = run_pipeline(job, stop_on_signal.token(), console, report);
  close_report(report, result, stop_on_signal.token().stop_requested(), begin);
  return conclude(report, result, job, common);
}

}  // namespace scanknit
