// A scan: from frames to a finished mesh, in one call.
#pragma once

#include <filesystem>
#include <optional>
#include <stop_token>

#include "scan/live/live_scanner.h"
#include "scan/scan_job.h"
#include "scan/scan_observer.h"
#include "scan/scan_result.h"

namespace scanknit {

/// Makes a mesh of a recording: tracks its frames (or takes their poses from the recording), fuses them, extracts and
/// finishes the surface, and writes all files of the job. If the walk comes back to a place, or the object turns on a
/// turntable, finds better poses and fuses all frames again. `stop`, or the observer's command kFinish, ends the
/// frames: what has been fused becomes the mesh. ScanResult::outcome: kOutput before any work; kInput without a usable
/// frame; kTooLittle when tracking was lost; kBudget; kMesh for an empty mesh; kUsage and kConfig for settings that
/// contradict each other.
[[nodiscard]] ScanResult scan_recording(const ScanJob& job, ScanObserver& observer, std::stop_token stop = {});

/// The same for a scanner that is plugged in. `stop` ends the frames; the steps after them still run.
struct LiveScanRequest {
  ScannerRequest scanner;
  std::optional<std::filesystem::path> recording;  ///< written while scanning; loops, turntables and textures need it
};
[[nodiscard]] ScanResult scan_live(const ScanJob& job, const LiveScanRequest& request, ScanObserver& observer,
                                   std::stop_token stop = {});

}  // namespace scanknit
