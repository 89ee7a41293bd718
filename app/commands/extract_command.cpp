#include <chrono>
#include <cmath>
#include <limits>

#include "app/commands/commands.h"
#include "app/report/conclude.h"
#include "app/terminal/signals.h"
#include "scan/mesh/write_texture.h"
#include "scan/volume/extract_volume.h"

namespace scanknit {
namespace {

/// The configuration, and whether any of its sources gives the isovalue: what is not a number stays so unless it is
/// set.
struct IsovalueAndConfig {
  ScanConfig config;
  bool has_isovalue;
};

Result<IsovalueAndConfig> load(const ConfigSources& sources) {
  ScanConfig config;
  const double built_in = config.extract.isovalue;
  config.extract.isovalue = std::numeric_limits<double>::quiet_NaN();
  auto loaded = load_config(sources, config);
  if (!loaded) return loaded.error();
  const bool has_isovalue = !std::isnan(loaded->extract.isovalue);
  if (!has_isovalue) loaded->extract.isovalue = built_in;
  return IsovalueAndConfig{std::move(*loaded), has_isovalue};
}

}  // namespace

int extract_command(const ExtractArguments& arguments, const CommonArguments& common) {
  // Before any other thread. A volume is meshed whole or, at a second signal, not at all.
  const StopOnSignal stop_on_signal;
  const auto begin = std::chrono::steady_clock::now();
  auto loaded = load(common.config);
  if (!loaded) return fail(loaded.error(), common);
  if (const auto off = refuse_texture(loaded->config, "extract"); !off) return fail(off.error(), common);
  const auto outputs = plan_outputs(arguments.outputs, loaded->config.output);
  if (!outputs) return fail(outputs.error(), common);

  VolumeRequest request{arguments.options, loaded->has_isovalue ? IsovalueWish::kGiven : IsovalueWish::kUnsaid};
  if (arguments.wants_auto_isovalue) request.isovalue = IsovalueWish::kAuto;
  const ScanJob job = job_of(arguments.volume, loaded->config, *outputs);
  Console console(common.verbosity);
  Run run = close_run(extract_volume(job, request, console, stop_on_signal.token()),
                      stop_on_signal.token().stop_requested(), begin);
  return conclude(run, *outputs, common, arguments.wants_stats);
}

}  // namespace scanknit
