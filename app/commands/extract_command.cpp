#include <chrono>
#include <cmath>
#include <limits>

#include "app/commands/commands.h"
#include "app/scan/extract_volume.h"
#include "app/scan/run_report.h"
#include "app/scan/texture_output.h"
#include "app/terminal/signals.h"

namespace scanknit {
namespace {

/// The configuration, and whether any of its sources gives the isovalue: what is not a number stays so unless it is
/// set.
struct IsovalueAndConfig {
  Config config;
  bool has_isovalue;
};

Result<IsovalueAndConfig> load(const ConfigSources& sources) {
  Config config;
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
  const StopOnSignal
      stop_on_signal;  // before any other thread; a volume is meshed whole or, at a second signal, not at all
  const auto begin = std::chrono::steady_clock::now();
  auto loaded = load(common.config);
  if (!loaded) return fail(loaded.error(), common);
  if (const auto off = refuse_texture(loaded->config, "extract"); !off) return fail(off.error(), common);
  const auto outputs = plan_outputs(arguments.outputs, loaded->config.output);
  if (!outputs) return fail(outputs.error(), common);

  VolumeRequest request{arguments.options, loaded->has_isovalue ? IsovalueWish::kGiven : IsovalueWish::kUnsaid};
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
