#include "app/report/conclude.h"

#include <utility>

#include "app/exit_codes.h"
#include "app/report/case_table.h"
#include "app/report/report_json.h"
#include "app/report/summary.h"
#include "core/files/atomic_file.h"
#include "export/report/report_page.h"
#include "export/trajectory.h"

namespace scanknit {
namespace {

/// True when the volume reached its budget, tracking was lost, and the incomplete volume was meshed.
bool is_partial(const CommandRun& run) {
  return run.exit_code == exit_code_of(ErrorCode::kBudget) && run.scan.mesh.check;
}

/// A report is written for all outcomes that say something about the input; not when an option, an output or the budget
/// was refused.
bool wants_report(const CommandRun& run) {
  switch (run.exit_code) {
    case exit_code_of(ErrorCode::kUsage):
    case exit_code_of(ErrorCode::kOutput): return false;
    case exit_code_of(ErrorCode::kBudget): return is_partial(run);
    default: return true;
  }
}

/// The report and its page: the report lists itself, too.
FilesByKind report_files(const Outputs& outputs) {
  FilesByKind files{{"report", outputs.report->string()}};
  if (outputs.page) files["page"] = outputs.page->string();
  return files;
}

Result<void> write_report(const std::string& json, const Outputs& outputs, const ScanResult& scan) {
  if (outputs.page) {
    if (auto written = write_report_page(json, *outputs.page, to_tum_trajectory(stamped_poses(scan.trajectory)));
        !written)
      return written;
  }
  return write_file_atomically(*outputs.report, json);
}

/// The report could not be written: prints that after an error of the scan; else it is the error of the run.
void note_failure(const Error& error, CommandRun& run, const CommonArguments& common) {
  run.report_files.clear();
  if (!run.scan.outcome) return (void)fail(error, common);
  run.scan.outcome = error;
  run.status = error.text();
  run.exit_code = exit_code_of(error.code);
}

std::string text_for_people(const CommandRun& run, const CommonArguments& common, bool with_case_table) {
  if (!run.scan.outcome && !is_partial(run)) return "";
  std::string text;
  if (common.verbosity != Verbosity::kQuiet) text = summary_text(run);
  if (with_case_table) text += (text.empty() ? "" : "\n") + case_table_text(run.scan.mesh.cases.value_or(CaseCounts{}));
  return text;
}

/// Says what helps, in words of the command line, which the scan does not know.
void advise(const CommandRun& run, const Outputs& outputs, const CommonArguments& common) {
  const bool has_frames = run.scan.outcome.error().code == ErrorCode::kTooLittle && run.scan.frames.fused > 0;
  if (!has_frames || outputs.scan.volume) return;
  Console(common.verbosity)
      .info("--save-volume FILE.vdb keeps the frames that were fused; scanknit extract makes a mesh of that file");
}

}  // namespace

int conclude(CommandRun& run, const Outputs& outputs, const CommonArguments& common, bool with_case_table) {
  const bool has_report = outputs.report && wants_report(run);
  if (has_report) run.report_files = report_files(outputs);
  std::string json = has_report || common.is_json ? report_json(run) : "";
  if (has_report) {
    if (auto written = write_report(json, outputs, run.scan); !written) {
      note_failure(written.error(), run, common);
      if (common.is_json) json = report_json(run);  // of the run as it ended now
    }
  }
  const std::string text = common.is_json ? std::move(json) : text_for_people(run, common, with_case_table);
  const int printed = text.empty() ? kExitOk : print_result(text, common);
  if (!run.scan.outcome) {
    (void)fail(run.scan.outcome.error(), common);
    advise(run, outputs, common);
  }
  return run.exit_code != kExitOk ? run.exit_code : printed;
}

}  // namespace scanknit
