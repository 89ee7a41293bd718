// FrameSource: one frame after another, from a recording or a scanner.
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "acquire/acquire_config.h"
#include "core/axes.h"
#include "core/frame.h"
#include "core/result.h"

namespace scanknit {

/// What is known of a recording without decoding all its frames.
struct RecordingInfo {
  std::string format;            ///< "7-scenes", "tum", "open3d", "phone-lidar", "pcd", "pclzf", "fakenect", "mcap",
                                 ///< "realsense-bag", "oni"
  std::filesystem::path folder;  ///< where its files lie: the path that was opened, or a folder below it;
                                 ///< or the file that is all of it
  std::size_t frames = 0;        ///< in the recording, whatever from/to/every select
  std::size_t frames_with_pose = 0;       ///< of those, with a pose entry (not yet checked)
  PoseMode poses = PoseMode::kRecording;  ///< as asked for; kAuto is settled
  bool has_colour = false;
  std::optional<CameraIntrinsics> intrinsics;         ///< of the first depth frame
  std::optional<CameraIntrinsics> colour_intrinsics;  ///< of the first colour frame
  std::optional<double> depth_scale;                  ///< raw units per metre; nothing when depth is floating point
  std::optional<double> duration_s;                   ///< nothing when the recording has no clock
  UpAxis world_up = UpAxis::kMinusY;                  ///< -y: the world is a camera's frame (y down)
  std::vector<std::string> warnings;                  ///< for people: what is wrong with the recording as a whole
};

/// One consumer; not thread-safe.
class FrameSource {
 public:
  virtual ~FrameSource() = default;

  [[nodiscard]] virtual const RecordingInfo& info() const = 0;

  /// When poses are tracked, frames may have no pose, and may have no depth either: that tells of a covered lens.
  /// Blocks until a frame, a dropped frame, the end, or an error that ends the source. A stop request is an
  /// EndOfStream.
  [[nodiscard]] virtual FrameEvent next(std::stop_token stop) = 0;

  /// Waits until next() would return at once, for `patience` at most, and says whether it would: for callers who have
  /// something else to do while a scanner, or a person, takes its time. A source that lets nobody wait says so at once.
  [[nodiscard]] virtual bool wait([[maybe_unused]] std::stop_token stop,
                                  [[maybe_unused]] std::chrono::milliseconds patience) {
    return true;
  }
};

/// Opens a recording: a folder, or one file of it; a folder that holds exactly one recording up to two levels below
/// stands for that recording (see RecordingInfo::folder). One .pcd or .pclzf file is a recording of one frame, one
/// .mcap, .bag or .oni file a whole recording. The format is recognised by content unless config.format names it.
/// Errors (kInput): nothing there, no format fits (the message lists those that are known), no frame at all, intrinsics
/// missing (the message says how to give them).
[[nodiscard]] Result<std::unique_ptr<FrameSource>> open_recording(const std::filesystem::path& path,
                                                                  const AcquireConfig& config);

}  // namespace scanknit
