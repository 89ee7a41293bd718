#include "scan/align/align.h"

#include <chrono>
#include <utility>

#include "app/commands/commands.h"
#include "app/report/conclude.h"
#include "app/terminal/signals.h"
#include "scan/mesh/write_texture.h"

namespace scanknit {
namespace {

/// True if somebody asked for a voxel size: two starts then give the same.
bool has_own_voxel_size(const ConfigSources& sources) {
  ScanConfig start;
  start.fusion.voxel_size_m = 0.0123;
  const auto config = load_config(sources, start);
  return config && config->fusion.voxel_size_m != start.fusion.voxel_size_m;
}

}  // namespace

int align_command(const AlignArguments& arguments, const CommonArguments& common) {
  const StopOnSignal stop_on_signal;  // before any other thread
  const auto begin = std::chrono::steady_clock::now();
  auto config = load_config(with_run_defaults(common.config));
  if (!config) return fail(config.error(), common);
  if (const auto off = refuse_texture(*config, "align"); !off) return fail(off.error(), common);
  const auto outputs = plan_outputs(arguments.outputs, config->output);
  if (!outputs) return fail(outputs.error(), common);
  AlignRequest request = arguments.request;
  request.has_voxel_size = has_own_voxel_size(common.config);

  const ScanJob job = job_of(request.inputs.front(), *config, *outputs);
  Console console(common.verbosity);
  Run run = close_run(align_and_mesh(job, request, console, stop_on_signal.token()),
                      stop_on_signal.token().stop_requested(), begin);
  return conclude(run, *outputs, common);
}

}  // namespace scanknit
