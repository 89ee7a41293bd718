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

/// A recording becomes a mesh: its frames are tracked (or their poses taken from the recording) and fused, the surface
/// is extracted and finished, and all files of the job are written. Where the walk comes back to a place, or the object
/// turns on a turntable, better poses are found and all frames are fused again. `stop`, or the observer's command
/// kFinish, ends the frames: what has been fused becomes the mesh. ScanResult::outcome: kOutput before any work; kInput
/// without a usable frame; kTooLittle when tracking was lost; kBudget; kMesh for an empty mesh; kUsage and kConfig for
/// what does not fit together.
[[nodiscard]] ScanResult scan_recording(const ScanJob& job, ScanObserver& observer, std::stop_token stop = {});

/// The same for a scanner that is plugged in. `stop` ends the frames; what comes after them is done all the same.
struct LiveScanRequest {
  ScannerRequest scanner;
  std::optional<std::filesystem::path> recording;  ///< is made while scanning; loops, turntables and textures need it
};
[[nodiscard]] ScanResult scan_live(const ScanJob& job, const LiveScanRequest& request, ScanObserver& observer,
                                   std::stop_token stop = {});

}  // namespace scanknit
