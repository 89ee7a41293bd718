#include <sys/resource.h>

#include <chrono>

#include "app/commands.h"
#include "app/config_print.h"
#include "app/exit_codes.h"
#include "app/pipeline.h"
#include "app/signals.h"
#include "app/summary.h"
#include "core/atomic_file.h"
#include "core/version.h"

namespace scanknit {
namespace {

double peak_rss_mib() {
  rusage usage{};
  if (getrusage(RUSAGE_SELF, &usage) != 0) return 0;
  return static_cast<double>(usage.ru_maxrss) / 1024;  // Linux counts KiB
}

RunReport begin_report(const Job& job) {
  RunReport report;
  report.version = kVersion;
  report.input = job.input.string();
  report.config_json = config_to_json(job.config);
  return report;
}

void close_report(RunReport& report, const Result<void>& result, bool was_interrupted,
                  std::chrono::steady_clock::time_point begin) {
  const std::chrono::duration<double, std::milli> spent = std::chrono::steady_clock::now() - begin;
  report.total_ms = spent.count();
  report.peak_rss_mib = peak_rss_mib();
  report.status = result ? "ok" : result.error().text();
  report.exit_code = result ? kExitOk : exit_code_of(result.error().code);
  if (!was_interrupted) return;
  report.exit_code = kExitInterrupted;
  if (result) report.status = "interrupted: what there was has been meshed and written";
}

/// Which outcomes leave a report: whatever was found out about the input. A refused disk or budget leaves none.
bool wants_report(const RunReport& report) {
  switch (report.exit_code) {
    case exit_code_of(ErrorCode::kOutput):
    case exit_code_of(ErrorCode::kBudget): return false;
    default: return true;
  }
}

Result<void> write_report(RunReport& report, const Job& job) {
  if (!job.outputs.report || !wants_report(report)) return {};
  report.files["report"] = job.outputs.report->string();
  return write_file_atomically(*job.outputs.report, to_json(report));
}

/// The report to its file, the result to stdout, the error to stderr. Returns the exit code.
int conclude(RunReport& report, Result<void> result, const Job& job, const CommonArguments& common) {
  if (auto written = write_report(report, job); !written && result) {
    result = written;
    report.status = written.error().text();
    report.exit_code = exit_code_of(written.error().code);
  }
  int printed = kExitOk;
  if (common.is_json) {
    printed = print_result(to_json(report), common);
  } else if (result && common.verbosity != Verbosity::kQuiet) {
    printed = print_result(summary_text(report), common);
  }
  if (!result) (void)fail(result.error(), common);
  return report.exit_code != kExitOk ? report.exit_code : printed;
}

}  // namespace

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

  const Job job{arguments.recording, std::move(*config), *outputs};
  RunReport report = begin_report(job);
  Console console(common.verbosity);
  const Result<void> result = run_pipeline(job, stop_on_signal.token(), console, report);
  close_report(report, result, stop_on_signal.token().stop_requested(), begin);
  return conclude(report, result, job, common);
}

int extract_command(const ExtractArguments& arguments, const CommonArguments& common) {
  const StopOnSignal
      stop_on_signal;  // before any other thread; a volume is meshed whole or, at a second signal, not at all
  const auto begin = std::chrono::steady_clock::now();
  auto config = load_config(common.config);
  if (!config) return fail(config.error(), common);
  const auto outputs = plan_outputs(
      {.output = arguments.output, .report = arguments.report, .trajectory = {}, .volume = {}, .has_trajectory = false},
      config->output);
  if (!outputs) return fail(outputs.error(), common);

  const Job job{arguments.volume, std::move(*config), *outputs};
  RunReport report = begin_report(job);
  const Result<void> result = extract_volume(job, report);
  close_report(report, result, stop_on_signal.token().stop_requested(), begin);
  return conclude(report, result, job, common);
}

}  // namespace scanknit
