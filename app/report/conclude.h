// The end of a command that makes a mesh: report, summary, exit code.
#pragma once

#include "app/commands.h"
#include "app/config/outputs.h"
#include "app/report/run.h"

namespace scanknit {

/// Writes the report to its file, the result to stdout, and an error to stderr. With --json the result is the report;
/// else a short summary (not with --quiet) and, if `with_case_table`, the frequency of the sub-cases. Returns the exit
/// code.
[[nodiscard]] int conclude(CommandRun& run, const Outputs& outputs, const CommonArguments& common,
                           bool with_case_table = false);

}  // namespace scanknit
