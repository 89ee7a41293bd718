// Finds a scanner for a live scan or a recording, opens it, and chooses its streams.
#pragma once

#include <stop_token>

#include "acquire/live/live_source.h"
#include "core/result.h"
#include "scan/scan.h"
#include "scan/scan_config.h"
#include "scan/scan_session.h"

namespace scanknit {

/// Whether the depth camera's calibration must be known.
enum class Calibration { kRequired, kOptional };

/// Errors: kUsage, kDevice (absent, no permission, in use; unknown calibration when it is required). Only warns of a
/// setting that the camera does not have. `stop` ends the wait for the scanner.
[[nodiscard]] Result<LiveScanner> open_scanner(const ScannerRequest& request, const ScanConfig& config,
                                               Calibration need, const std::stop_token& stop, ScanSession& session);

/// Options with the limits of the request. Events of the scanner become warnings of `session`, which outlives the
/// source.
[[nodiscard]] LiveOptions live_options(const ScannerRequest& request, PoseMode poses, ScanSession& session);

/// Warns of lost pictures, if there are any.
void warn_of_losses(const LossCounters& losses, ScanSession& session);

}  // namespace scanknit
