// A scanner for live scans and recordings: found, opened, and what it shall send chosen.
#pragma once

#include <cstdint>
#include <map>
#include <stop_token>
#include <string>

#include "acquire/live/live_source.h"
#include "core/result.h"
#include "scan/live/scanner_request.h"
#include "scan/scan_config.h"
#include "scan/scan_session.h"

namespace scanknit {

/// Whether the depth camera must be known.
enum class Calibration { kNeeded, kWelcome };

/// Errors: kUsage, kDevice (absent, forbidden, in use; without a known calibration when that is needed).
/// A setting that the camera does not have is warned of, no more. `stop` ends the waiting for it.
[[nodiscard]] Result<LiveScanner> open_scanner(const ScannerRequest& request, const ScanConfig& config,
                                               Calibration need, const std::stop_token& stop, ScanSession& session);

/// The limits of the request; what happens to the scanner becomes a warning of `session`, which outlives the source.
[[nodiscard]] LiveOptions live_options(const ScannerRequest& request, PoseMode poses, ScanSession& session);

/// By their names in the report.
[[nodiscard]] std::map<std::string, std::uint64_t> named(const LossCounters& losses);

/// Warns of what was lost, if anything was.
void warn_of_losses(const LossCounters& losses, ScanSession& session);

}  // namespace scanknit
