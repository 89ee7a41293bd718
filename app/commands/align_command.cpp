#include "scan/align/align.h"

#include <chrono>
#include <utility>

#include "app/commands.h"
#include "app/report/conclude.h"
#include "app/terminal/scan_console.h"
#include "app/terminal/signals.h"
#include "scan/mesh/write_texture.h"

namespace scanknit {

int align_command(const AlignArguments& arguments, const CommonArguments& common) {
  const StopOnSignal stop_on_signal;  // must come before any other thread
  const auto begin = std::chrono::steady_clock::now();
  const auto loaded = load_config(with_run_defaults(common.config));
  if (!loaded) return fail(loaded.error(), common);
  if (const auto off = refuse_texture(loaded->config, "align"); !off) return fail(off.error(), common);
  const auto outputs = plan_outputs(arguments.outputs, loaded->config.output);
  if (!outputs) return fail(outputs.error(), common);
  AlignRequest request = arguments.request;
  request.has_voxel_size = loaded->gives("fusion.voxel_size");

  const ScanJob job = job_of(request.inputs.front(), loaded->config, *outputs);
  ScanConsole console(common.verbosity);
  ScanResult scan = align_and_mesh(job, request, console, stop_on_signal.token());
  CommandRun run = close_run(std::move(scan), stop_on_signal.token().stop_requested(), begin);
  return conclude(run, *outputs, common);
}

}  // namespace scanknit
