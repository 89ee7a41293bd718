// ScanObserver: who looks on while a scan goes on, and may steer it. A live view, a progress bar, a test.
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <stop_token>
#include <string_view>

#include "acquire/frame_source.h"
#include "core/axes.h"
#include "core/frame.h"
#include "core/result.h"
#include "scan/scan_result.h"
#include "scan/scan_warning.h"

namespace scanknit {

class TsdfVolume;

/// How important a message is.
enum class LogLevel { kDebug, kInfo, kWarning, kError };

/// What a scan is doing.
enum class ScanPhase {
  kWaiting,    ///< no frame has been fused or lost yet
  kScanning,   ///< frames are tracked and fused
  kPaused,     ///< a person paused it
  kExporting,  ///< a person asked for the mesh of what is there
  kWriting,    ///< there are no more frames: meshes are made, poses refined, frames fused again
};

/// What a person may ask of a scan.
struct ScanCommand {
  enum class Kind { kStart, kPause, kReset, kCrop, kExport, kFinish };
  Kind kind = Kind::kStart;
  CropBox box = {};  ///< of kCrop
};

/// A running scan as its observer sees it. Valid during the call.
struct ScanState {
  ScanPhase phase;
  const RecordingInfo& info;
  const FrameCounts& frames;
  const Trajectory& trajectory;
  const TrackedFrame* newest;          ///< how the last frame was tracked; null where poses are given
  std::optional<DropReason> trouble;   ///< why the last few frames could not be used
  const CropBox& crop;                 ///< nothing is meshed outside of it
  std::optional<LossCounters> losses;  ///< of a scanner: pictures that never arrived
  TsdfVolume& volume;                  ///< keeps its address. An observer may take its changed blocks, no more
};

/// Every function is called by the thread that scans, between two frames: it should return soon. The base class ignores
/// all it is told and asks for nothing.
class ScanObserver {
 public:
  virtual ~ScanObserver() = default;

  /// What a person may like to know. Warnings do not come this way.
  virtual void on_message([[maybe_unused]] LogLevel level, [[maybe_unused]] std::string_view text) {}
  virtual void on_warning([[maybe_unused]] const ScanWarning& warning) {}
  /// `done` of `total` steps of what a few words name; `total` 0: unknown.
  virtual void on_progress([[maybe_unused]] std::string_view what, [[maybe_unused]] std::size_t done,
                           [[maybe_unused]] std::size_t total) {}

  /// The recording has been opened; nothing of it was read. An error ends the scan.
  [[nodiscard]] virtual Result<void> on_open([[maybe_unused]] const RecordingInfo& info) { return {}; }
  /// The volume is empty: the scan begins, for a second time after a reset, and when the frames are read once more
  /// because they show no turntable. An error ends the scan, or is the answer to the reset.
  [[nodiscard]] virtual Result<void> on_begin([[maybe_unused]] const ScanState& scan) { return {}; }
  /// A frame was fused at this pose, or lost.
  virtual void on_frame([[maybe_unused]] const Frame& frame, [[maybe_unused]] const std::optional<Pose>& T_world_camera,
                        [[maybe_unused]] const ScanState& scan) {}
  /// A frame could not be used, or none has come for a moment, or one passed by while the scan is paused.
  virtual void on_no_frame([[maybe_unused]] const Frame* passed_by, [[maybe_unused]] const ScanState& scan) {}
  /// `scan.phase` is another one than before.
  virtual void on_phase([[maybe_unused]] const ScanState& scan) {}
  /// The mesh of the frames as they were tracked has been written.
  virtual void on_tracked_mesh([[maybe_unused]] const ScanState& scan) {}
  /// Better poses were found and all frames have been fused again.
  virtual void on_refined([[maybe_unused]] const ScanState& scan) {}

  /// What a person asked for since the last call; waits for `patience` at most.
  [[nodiscard]] virtual std::optional<ScanCommand> next_command([[maybe_unused]] std::stop_token stop,
                                                                [[maybe_unused]] std::chrono::nanoseconds patience) {
    return std::nullopt;
  }
  /// What became of the last command. `files` are those that kExport wrote.
  virtual void on_answer([[maybe_unused]] const ScanCommand& command, [[maybe_unused]] const Result<void>& outcome,
                         [[maybe_unused]] const FilesByKind& files, [[maybe_unused]] const ScanState& scan) {}
};

}  // namespace scanknit
