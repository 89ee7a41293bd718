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

/// A recording becomes a mesh: its frames are tracked (or their poses taken from the recording) and fused, the surface
/// is extracted and finished, and all files of the job are written. Where the walk comes back to a place, or the object
/// turns on a turntable, better poses are found and all frames are fused again. `stop`, or the observer's command
/// kFinish, ends the frames: what has been fused becomes the mesh. ScanResult::outcome: kOutput before any work; kInput
/// without a usable frame; kTooLittle when tracking was lost; kBudget; kMesh for an empty mesh; kUsage and kConfig for
/// what does not fit together.
[[nodiscard]] ScanResult scan_recording(const ScanJob& job, ScanObserver& observer, std::stop_token stop = {});

/// Which scanner, and for how long it is listened to.
struct ScannerRequest {
  std::string device = {};  ///< as `scanknit devices` lists it; empty: the first that is found
  int width = 640, height = 480;           ///< of depth, pixels; the camera's nearest is taken
  double frames_per_second = 30;           ///< likewise
  std::optional<std::size_t> frames = {};  ///< depth pictures after which it ends
  std::optional<double> seconds = {};      ///< ... or so long after the first
  double wait_s = 0;                       ///< for a scanner that is not plugged in yet
  double reconnect_s = 30;                 ///< for one that was unplugged
  bool takes_from_others = false;          ///< also a scanner that another program uses
};

struct LiveScanRequest {
  ScannerRequest scanner;
  std::optional<std::filesystem::path>
      recording;  ///< .mcap; is made while scanning; loops, turntables and textures need it
};
/// The same for a scanner that is plugged in. `stop` ends the frames; what comes after them is done all the same.
/// ScanResult::outcome: also kDevice for a scanner that is absent, busy or forbidden.
[[nodiscard]] ScanResult scan_live(const ScanJob& job, const LiveScanRequest& request, ScanObserver& observer,
                                   std::stop_token stop = {});

}  // namespace scanknit
