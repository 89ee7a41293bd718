// FrameSource: delivers frames one by one, from a recording or a scanner.
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "acquire/acquire_config.h"
#include "core/axes.h"
#include "core/frame.h"
#include "core/noise_model.h"
#include "core/result.h"

namespace scanknit {

/// Which sensor made a recording, and how that is known.
struct RecognisedSensor {
  SensorModel model = SensorModel::kNone;
  std::string reason;                        ///< for the user: "its depth lies on ..."
  bool is_by_depth = false;                  ///< by its depth alone: it may be a simulation of that sensor
  std::optional<NoiseModel> own_noise = {};  ///< of this very device, whatever the model's: a stereo rig states it
};

/// The properties of a recording that are known without decoding all frames.
struct RecordingInfo {
  std::string format;                     ///< "7-scenes", "tum", "open3d", "nerfstudio", "phone-lidar", "pcd", "pclzf",
                                          ///< "fakenect", "mcap", "ros2", "ros1", "realsense-bag", "oni", "sens",
                                          ///< "stray-scanner", "arkitscenes", "polycam", "record3d", "replica", "bop",
                                          ///< "azure-mkv", "stereo"
  std::filesystem::path folder;           ///< where its files lie: the path that was opened, or a folder below it;
                                          ///< or the file that is all of it
  std::size_t frames = 0;                 ///< all frames of the recording, also those that from/to/every do not select
  std::size_t frames_with_pose = 0;       ///< those with a pose entry (not checked yet)
  PoseMode poses = PoseMode::kRecording;  ///< the mode in use, never kAuto
  bool has_colour = false;
  std::optional<CameraIntrinsics> intrinsics;         ///< of the first depth frame
  std::optional<CameraIntrinsics> colour_intrinsics;  ///< of the first colour frame
  std::optional<double> depth_scale;                  ///< raw units per metre; nothing when depth is floating point
  std::optional<double> duration_s;                   ///< nothing when the recording has no clock
  std::optional<RecognisedSensor> sensor;             ///< nothing: not recognised, or config.sensor names it
  UpAxis world_up = UpAxis::kMinusY;                  ///< -y: the world is a camera's frame (y down)
  std::map<std::string, std::string> topics;          ///< of recordings that have some: what each that is read is for
                                                      ///< ("depth", "colour", "poses"), and "not_read"
  std::vector<std::string> warnings;                  ///< messages: faults of the recording as a whole
};

/// One consumer; not thread-safe.
class FrameSource {
 public:
  virtual ~FrameSource() = default;

  [[nodiscard]] virtual const RecordingInfo& info() const = 0;

  /// Blocks until a frame, a dropped frame, the end, or an error that ends the source. A stop request gives an
  /// EndOfStream. When poses are tracked, frames may lack a pose, and also depth, for example with a covered lens.
  [[nodiscard]] virtual FrameEvent next(std::stop_token stop) = 0;

  /// Waits until next() would return at once, for at most `patience`; returns whether it would. For callers that have
  /// other work while a scanner, or the user, is slow. A source that never makes callers wait returns true at once.
  [[nodiscard]] virtual bool wait([[maybe_unused]] std::stop_token stop,
                                  [[maybe_unused]] std::chrono::milliseconds patience) {
    return true;
  }
};

/// Opens a recording: a folder, one file of it, or a folder with exactly one recording up to two levels below (see
/// RecordingInfo::folder). One .pcd or .pclzf file is a recording of one frame, one .mcap, .bag or .oni file a whole
/// recording. Recognises the format by content unless config.format names it. Errors (kInput): the path does not exist,
/// no format fits (the message lists the known formats), no frame, intrinsics are missing (the message says how to give
/// them).
[[nodiscard]] Result<std::unique_ptr<FrameSource>> open_recording(const std::filesystem::path& path,
                                                                  const AcquireConfig& config);

}  // namespace scanknit
