// CommandRun: a scan's result, and how the command ended.
#pragma once

#include <chrono>
#include <string>

#include "scan/scan_result.h"

namespace scanknit {

struct CommandRun {
  ScanResult scan;
  std::string status;  ///< "ok", or the error's text
  int exit_code = 0;
  double total_ms = 0;
  double peak_rss_mib = 0;
  FilesByKind report_files = {};  ///< the report and its page; empty: there is no report
};

/// The scan's files and those of the report.
[[nodiscard]] FilesByKind files_of(const CommandRun& run);

/// `begin`: when the command began. `was_interrupted`: by a signal, unless a signal is the command's normal end.
[[nodiscard]] CommandRun close_run(ScanResult scan, bool was_interrupted, std::chrono::steady_clock::time_point begin);

}  // namespace scanknit
