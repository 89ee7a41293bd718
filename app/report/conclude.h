// The end of a command that makes a mesh: its report, its summary, its exit code.
#pragma once

#include "app/commands/commands.h"
#include "app/config/outputs.h"
#include "app/report/run.h"

namespace scanknit {

/// The report to its file, the result to stdout, the error to stderr. The result is the report with --json, else a few
/// lines of summary (not with --quiet) and, `with_case_table`, the frequency of the sub-cases. Returns the exit code.
[[nodiscard]] int conclude(CommandRun& run, const Outputs& outputs, const CommonArguments& common,
                           bool with_case_table = false);

}  // namespace scanknit
