#include <chrono>

#include "app/commands/commands.h"
#include "app/scan/extract_volume.h"
#include "app/scan/run_report.h"
#include "app/scan/texture_output.h"
#include "app/terminal/signals.h"

namespace scanknit {
int extract_command(const ExtractArguments& arguments, const CommonArguments& common) {
  const StopOnSignal
      stop_on_signal;  // before any other thread; a volume is meshed whole or, at a second signal, not at all
  const auto begin = std::chrono::steady_clock::now();
  auto loaded = load_config(common.config);
  if (!loaded) return fail(loaded.error(), common);
  if (const auto off = refuse_texture(loaded->config, "extract"); !off) return fail(off.error(), common);
  const auto outputs = plan_outputs(arguments.outputs, loaded->config.output);
  if (!outputs) return fail(outputs.error(), common);

  VolumeRequest request{arguments.options,
                        loaded->gives("extract.isovalue") ? IsovalueWish::kGiven : IsovalueWish::kUnsaid};
  if (arguments.wants_auto_isovalue) request.isovalue = IsovalueWish::kAuto;
  const Job job{arguments.volume, std::move(loaded->config), *outputs};
  RunReport report = begin_report(job);
  Console console(common.verbosity);
  warn_of_unused_options(job, console, report);
  const Result<void> result = extract_volume(job, request, stop_on_signal.token(), console, report);
  close_report(report, result, stop_on_signal.token().stop_requested(), begin);
  return conclude(report, result, job, common, arguments.wants_stats);
}

}  // namespace scanknit
