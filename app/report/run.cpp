#include "app/report/run.h"

#include <utility>

#include "app/exit_codes.h"
#include "core/system/peak_memory.h"

namespace scanknit {

FilesByKind files_of(const CommandRun& run) {
  FilesByKind files = run.scan.files;
  files.insert(run.report_files.begin(), run.report_files.end());
  return files;
}

CommandRun close_run(ScanResult scan, bool was_interrupted, std::chrono::steady_clock::time_point begin) {
  const std::chrono::duration<double, std::milli> spent = std::chrono::steady_clock::now() - begin;
  CommandRun run{std::move(scan), "ok", kExitOk, spent.count(), peak_rss_mib()};
  const Result<void>& outcome = run.scan.outcome;
  if (!outcome) {
    run.status = outcome.error().text();
    run.exit_code = exit_code_of(outcome.error().code);
  }
  if (!was_interrupted) return run;
  run.exit_code = kExitInterrupted;
  if (outcome) run.status = "interrupted: the data so far were meshed and written";
  return run;
}

}  // namespace scanknit
