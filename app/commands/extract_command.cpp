#include <chrono>
#include <utility>

#include "app/commands.h"
#include "app/report/conclude.h"
#include "app/terminal/scan_console.h"
#include "app/terminal/signals.h"
#include "scan/mesh/write_texture.h"
#include "scan/volume/extract_volume.h"

namespace scanknit {

int extract_command(const ExtractArguments& arguments, const CommonArguments& common) {
  // Must come before any other thread. A volume is meshed as a whole, or, at a second signal, not at all.
  const StopOnSignal stop_on_signal;
  const auto begin = std::chrono::steady_clock::now();
  auto loaded = load_config(common.config);
  if (!loaded) return fail(loaded.error(), common);
  if (const auto off = refuse_texture(loaded->config, "extract"); !off) return fail(off.error(), common);
  const auto outputs = plan_outputs(arguments.outputs, loaded->config.output);
  if (!outputs) return fail(outputs.error(), common);

  VolumeRequest request{arguments.options,
                        loaded->gives("extract.isovalue") ? IsovalueSetting::kGiven : IsovalueSetting::kNotGiven};
  if (arguments.wants_auto_isovalue) request.isovalue = IsovalueSetting::kAuto;
  const ScanJob job = job_of(arguments.volume, loaded->config, *outputs);
  ScanConsole console(common.verbosity);
  ScanResult scan = extract_volume(job, request, console, stop_on_signal.token());
  CommandRun run = close_run(std::move(scan), stop_on_signal.token().stop_requested(), begin);
  return conclude(run, *outputs, common, arguments.wants_stats);
}

}  // namespace scanknit
