#include "app/scan/run_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/resource.h>

#include "app/cli/exit_codes.h"
#include "app/config/config_print.h"
#include "app/terminal/case_table.h"
#include "app/terminal/summary.h"
#include "core/files/atomic_file.h"
#include "core/version.h"
#include "export/report/report_page.h"

namespace scanknit {
namespace {

double peak_rss_mib() {
  rusage usage{};
  if (getrusage(RUSAGE_SELF, &usage) != 0) return 0;
  return static_cast<double>(usage.ru_maxrss) / 1024;  // Linux counts KiB
}

/// A volume that was full and lost its camera is meshed as far as it goes.
bool is_partial(const RunReport& report) {
  return report.exit_code == exit_code_of(ErrorCode::kBudget) && report.mesh;
}

/// Which outcomes leave a report: whatever was found out about the input. A refused option, disk or budget leaves none.
bool wants_report(const RunReport& report) {
  switch (report.exit_code) {
    case exit_code_of(ErrorCode::kUsage):
    case exit_code_of(ErrorCode::kOutput): return false;
    case exit_code_of(ErrorCode::kBudget): return is_partial(report);
    default: return true;
  }
}

Result<void> write_report(RunReport& report, const Job& job) {
  if (!job.outputs.report || !wants_report(report)) return {};
  report.files["report"] = job.outputs.report->string();
  if (job.outputs.page) report.files["page"] = job.outputs.page->string();
  const std::string json = to_json(report);
  const auto poses = report.files.find("trajectory");  // of this run, wherever it is
  const std::filesystem::path trajectory = poses == report.files.end() ? "" : poses->second;
  if (job.outputs.page) {  // first: report.json must not tell of a success that was none
    if (auto written = write_report_page(json, *job.outputs.page, trajectory); !written) return written;
  }
  return write_file_atomically(*job.outputs.report, json);
}

/// With the key that each of them belongs to.
std::vector<std::string> unused_finish_keys(const FinishConfig& config) {
  std::vector<std::string> unused;
  if (config.ground == GroundWish::kKeep && config.ground_clearance_m) {
    unused.emplace_back("finish.ground_clearance (finish.ground)");
  }
  if (config.watertight != Watertight::kOff) return unused;
  if (config.max_hole_m != FinishConfig{}.max_hole_m) unused.emplace_back("finish.max_hole (finish.watertight)");
  if (config.invented_colour) unused.emplace_back("finish.mark_invented (finish.watertight)");
  return unused;
}

}  // namespace

RunReport begin_report(const Job& job) {
  RunReport report;
  report.version = kVersion;
  report.input = job.input.string();
  report.config_json = config_to_json(job.config);
  return report;
}

void warn_of_unused_options(const Job& job, Console& console, RunReport& report) {
  const auto warn_of = [&](const std::vector<std::string>& unused, const char* why) {
    if (unused.empty()) return;
    report.warnings.push_back(fmt::format("{}: {}", fmt::join(unused, ", "), why));
    console.warn(report.warnings.back());
  };
  warn_of(unused_glb_keys(job.outputs, job.config.output), "for GLB only, and none is written");
  warn_of(unused_finish_keys(job.config.finish), "of no effect, since the key in brackets is off");
  const FinishConfig& finish = job.config.finish;
  if (finish.watertight == Watertight::kFull && finish.max_hole_m != FinishConfig{}.max_hole_m) {
    warn_of({"finish.max_hole"}, "of no effect with finish.watertight: full, which closes every hole");
  }
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

int conclude(RunReport& report, Result<void> result, const Job& job, const CommonArguments& common,
             bool with_case_table) {
  if (auto written = write_report(report, job); !written) {
    report.files.erase("report");
    report.files.erase("page");
    if (!result) (void)fail(written.error(), common);
    if (result) {
      result = written;
      report.status = written.error().text();
      report.exit_code = exit_code_of(written.error().code);
    }
  }
  std::string text;
  if (common.is_json) {
    text = to_json(report);
  } else if (result || is_partial(report)) {
    if (common.verbosity != Verbosity::kQuiet) text = summary_text(report);
    if (with_case_table) text += (text.empty() ? "" : "\n") + case_table_text(report.extract);
  }
  const int printed = text.empty() ? kExitOk : print_result(text, common);
  if (!result) (void)fail(result.error(), common);
  return report.exit_code != kExitOk ? report.exit_code : printed;
}

}  // namespace scanknit
