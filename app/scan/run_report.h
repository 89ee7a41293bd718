// The report of a command, from its beginning to where it is written.
#pragma once

#include <chrono>

#include "app/commands/commands.h"
#include "app/scan/pipeline.h"
#include "core/result.h"
#include "export/report/report.h"

namespace scanknit {

[[nodiscard]] RunReport begin_report(const Job& job);

/// Before the work: a warning where something is set that cannot change any of the files to come.
void warn_of_unused_options(const Job& job, Console& console, RunReport& report);

/// Notes how it ended, and what it took since `begin`.
void close_report(RunReport& report, const Result<void>& result, bool was_interrupted,
                  std::chrono::steady_clock::time_point begin);

/// The report to its file, the result to stdout, the error to stderr. The result is the report with --json, else a few
/// lines of summary (not with --quiet) and, `with_case_table`, the frequency of the sub-cases. Returns the exit code.
[[nodiscard]] int conclude(RunReport& report, Result<void> result, const Job& job, const CommonArguments& common,
                           bool with_case_table = false);

}  // namespace scanknit
