// Recording: the index that every layout builds, and what its decoders return. Private to the room.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "acquire/frame_source.h"
#include "acquire/rare.h"
#include "acquire/shared_path.h"
#include "core/axes.h"
#include "core/camera.h"
#include "core/frame.h"
#include "core/limits.h"
#include "core/pose.h"
#include "core/result.h"

namespace scanknit {

/// Why one frame cannot be used; the recording continues.
struct Drop {
  DropReason reason = DropReason::kUnreadable;
  Error error;
};

template <typename T>
using OrDrop = std::variant<T, Drop>;

[[nodiscard]] inline Drop make_drop(DropReason reason, std::string message, const std::filesystem::path& where) {
  return Drop{reason, Error{ErrorCode::kInput, std::move(message), where.string()}};
}

/// One frame of a recording, as known before its pictures are opened.
struct FrameEntry {
  std::uint64_t sequence = 0;  ///< the recording's own frame number, else its position
  std::optional<std::int64_t> timestamp_ns = {};
  SharedPath depth = {};
  SharedPath colour = {};       ///< empty: this frame has no colour
  SharedPath confidence = {};   ///< empty: every depth pixel is trusted
  std::size_t depth_index = 0;  ///< index of the picture in a file with many pictures
  std::size_t colour_index = 0;
  /// Nothing: no pose; an Error: why the recorded pose is invalid. Frames may share it, and many have none.
  Rare<Result<Pose>> T_world_camera = {};
  Rare<CameraIntrinsics> camera = {};  ///< this frame's own camera, for its decoder
  Rare<CameraIntrinsics> colour_camera = {};
  Rare<double> depth_scale = {};  ///< raw units per metre, if each frame has its own
  Rare<Drop> fault = {};          ///< found while indexing: the frame is dropped without opening it
};

/// The decoded files of a frame. Cameras and pose only if the files have them.
struct DecodedFrame {
  DepthImage depth_m;
  ColourImage colour;                                                      ///< empty: none
  std::shared_ptr<const std::vector<std::byte>> encoded_colour = nullptr;  ///< see ColourFrame::encoded
  std::optional<CameraIntrinsics> camera = {};
  std::optional<CameraIntrinsics> colour_camera = {};
  Pose T_colour_depth = Pose::Identity();
  std::optional<Result<Pose>> T_world_camera = {};
};

struct DecodeSettings {
  double depth_scale = 1000.0;  ///< raw units per metre
  int min_confidence = 0;
  Limits limits;
};

using DecodeFrame = std::function<OrDrop<DecodedFrame>(const FrameEntry&, const DecodeSettings&)>;

struct Recording {
  const char* format = "";
  std::filesystem::path folder = {};
  std::string device = {};                      ///< the sensor's name; empty: the recording does not say it
  std::string serial = {};                      ///< of the device; the same
  std::optional<RecognisedSensor> sensor = {};  ///< by its names
  std::vector<FrameEntry> entries = {};
  std::optional<CameraIntrinsics> camera = {};  ///< of depth; width and height 0: the size of the picture
  double depth_scale = 1000.0;                  ///< raw units per metre, for entries without their own
  bool has_metric_depth = false;                ///< depth is floating point; `depth_scale` does not apply
  bool frames_bring_camera = false;             ///< the decoder gives each frame's camera
  bool frames_bring_pose = false;               ///< the decoder gives each frame's pose
  UpAxis world_up = UpAxis::kMinusY;
  std::map<std::string, std::string> topics = {};  ///< see RecordingInfo
  std::vector<std::string> warnings = {};
  DecodeFrame decode = {};
};

/// Makes the times of `entries` ascend strictly, in the order in which they stand: where a stamp is not after the one
/// before it, the clock goes on by the recording's usual interval (the median), and all later times are moved along.
/// Returns how often that was; 0: nothing is changed. Removes all times if the moved ones do not fit 64 bits.
std::size_t make_times_ascend(std::vector<FrameEntry>& entries);

}  // namespace scanknit
