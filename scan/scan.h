// scan_recording, scan_live: from frames to a finished mesh, in one call.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>

#include "scan/scan_job.h"
#include "scan/scan_observer.h"
#include "scan/scan_result.h"

namespace scanknit {

/// Makes a mesh of a recording: tracks its frames (or takes their poses from the recording), fuses them, extracts and
/// finishes the surface, and writes all files of the job. If the walk comes back to a place, or the object turns on a
/// turntable, finds better poses and fuses all frames again. The observer's command kFinish ends the frames; all other
/// steps follow. `stop` ends the frames, too, and leaves out what would take long: what has been fused becomes the
/// mesh, at the tracked poses and without a texture. ScanResult::outcome: kOutput before any work; kInput without a
/// usable frame; kTooLittle when tracking was lost; kBudget; kMesh for an empty mesh; kUsage and kConfig for settings
/// that contradict each other.
[[nodiscard]] ScanResult scan_recording(const ScanJob& job, ScanObserver& observer, std::stop_token stop = {});

/// Which scanner to use, and when to stop.
struct ScannerRequest {
  std::string device = {};                 ///< DeviceInfo::uri; empty: the first
  int width = 640, height = 480;           ///< of the depth picture, pixels; the camera's nearest size is used
  double frames_per_second = 30;           ///< the camera's nearest rate is used
  std::optional<std::size_t> frames = {};  ///< stop after this many depth pictures
  std::optional<double> seconds = {};      ///< stop this long after the first picture
  double wait_s = 0;                       ///< how long to wait for a scanner that is not plugged in yet
  double reconnect_s = 30;                 ///< how long to wait for a scanner that was unplugged
  bool takes_from_others = false;          ///< also a scanner that another program uses
};

struct LiveScanRequest {
  ScannerRequest scanner;
  /// .mcap, written while scanning; loops, turntables and textures need it.
  std::optional<std::filesystem::path> recording;
};
/// The same for a scanner that is plugged in. `stop` ends the frames; the steps after them still run.
/// ScanResult::outcome: also kDevice for a scanner that is absent, busy or forbidden.
[[nodiscard]] ScanResult scan_live(const ScanJob& job, const LiveScanRequest& request, ScanObserver& observer,
                                   std::stop_token stop = {});

}  // namespace scanknit
