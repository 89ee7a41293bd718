// ScanObserver: watches a running scan and may steer it. A live view, a progress bar, a test.
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

namespace scanknit {

class TsdfVolume;

/// How important a message is.
enum class LogLevel { kDebug, kInfo, kWarning, kError };

/// What a scan is doing.
enum class ScanPhase {
  kWaiting,    ///< no frame has been fused or lost so far
  kScanning,   ///< frames are tracked and fused
  kPaused,     ///< the user paused the scan
  kExporting,  ///< the user asked for the mesh of the frames so far
  kWriting,    ///< the frames have ended: poses are refined, frames fused again, meshes made
};

/// What the user can ask of a scan.
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
  const TrackedFrame* newest;          ///< how the last frame was tracked; null when poses are given
  std::optional<DropReason> trouble;   ///< why the last few frames could not be used
  const CropBox& crop;                 ///< no mesh outside of it
  std::optional<LossCounters> losses;  ///< of a scanner: pictures that never arrived
  TsdfVolume& volume;                  ///< keeps its address; observers may only take its changed blocks
};

/// The scanning thread calls every function between two frames: each should return soon. The functions of the base
/// class do nothing.
class ScanObserver {
 public:
  virtual ~ScanObserver() = default;

  /// A message for the user. Warnings are not reported by this function.
  virtual void on_message([[maybe_unused]] LogLevel level, [[maybe_unused]] std::string_view text) {}
  virtual void on_warning([[maybe_unused]] const ScanWarning& warning) {}
  /// `done` of `total` steps are done; `total` 0: unknown. `what` names the work in a few words.
  virtual void on_progress([[maybe_unused]] std::string_view what, [[maybe_unused]] std::size_t done,
                           [[maybe_unused]] std::size_t total) {}

  /// The recording has been opened; no frame has been read. An error ends the scan.
  [[nodiscard]] virtual Result<void> on_open([[maybe_unused]] const RecordingInfo& info) { return {}; }
  /// The scan begins, with an empty volume. Called again after a reset, and whenever the frames are read once more: the
  /// recording of a live scan, to find a turntable; frames that show no turntable, as a walk; frames of a walk that fit
  /// badly in quick turns, with the sensor's rolling shutter, then perhaps without it. An error ends the scan, or is
  /// the answer to the reset.
  [[nodiscard]] virtual Result<void> on_begin([[maybe_unused]] const ScanState& scan) { return {}; }
  /// A frame was fused at this pose, or tracking was lost at it.
  virtual void on_frame([[maybe_unused]] const Frame& frame, [[maybe_unused]] const std::optional<Pose>& T_world_camera,
                        [[maybe_unused]] const ScanState& scan) {}
  /// A frame could not be used, or none has come for a moment, or one was skipped because the scan is paused.
  virtual void on_no_frame([[maybe_unused]] const Frame* skipped, [[maybe_unused]] const ScanState& scan) {}
  /// `scan.phase` has changed.
  virtual void on_phase([[maybe_unused]] const ScanState& scan) {}
  /// The mesh of the tracked frames has been written.
  virtual void on_tracked_mesh([[maybe_unused]] const ScanState& scan) {}
  /// Better poses were found and all frames have been fused again.
  virtual void on_refined([[maybe_unused]] const ScanState& scan) {}
  /// Whether it reads `scan.volume` after the last mesh was made. If not, the volume is freed before that mesh is
  /// finished and written, and is empty in on_tracked_mesh().
  [[nodiscard]] virtual bool needs_volume_after_mesh() const { return true; }

  /// The next command of the user; waits for it for at most `patience`.
  [[nodiscard]] virtual std::optional<ScanCommand> next_command([[maybe_unused]] std::stop_token stop,
                                                                [[maybe_unused]] std::chrono::nanoseconds patience) {
    return std::nullopt;
  }
  /// Reports the outcome of the last command. `files` are those that kExport wrote.
  virtual void on_answer([[maybe_unused]] const ScanCommand& command, [[maybe_unused]] const Result<void>& outcome,
                         [[maybe_unused]] const FilesByKind& files, [[maybe_unused]] const ScanState& scan) {}
};

}  // namespace scanknit
