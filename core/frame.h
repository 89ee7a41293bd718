// Frame: the pictures of a scanner at one moment; and the events of a source of frames.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/camera.h"
#include "core/image.h"
#include "core/pose.h"
#include "core/result.h"

namespace scanknit {

/// A colour picture with its own resolution and camera.
struct ColourFrame {
  ColourImage image;                       ///< sRGB
  CameraIntrinsics intrinsics;             ///< of `image`
  Pose T_colour_depth = Pose::Identity();  ///< p_colour = T_colour_depth * p_depth
  /// The PNG or JPEG file that `image` was decoded from; null when there was none, or when `image` was undistorted.
  std::shared_ptr<const std::vector<std::byte>> encoded = nullptr;
};

struct Frame {
  std::uint64_t sequence = 0;     ///< strictly increasing within a source; the recording's own number if it has one
  std::int64_t timestamp_ns = 0;  ///< strictly increasing; see `has_clock`
  bool has_clock = false;         ///< false: the recording has no time stamps and timestamp_ns counts frames
  DepthImage depth_m;             ///< metres, 0 = no return
  CameraIntrinsics intrinsics;    ///< of `depth_m`
  std::optional<ColourFrame> colour;
  Image<Eigen::Vector3f>
      normals;  ///< camera frame, unit, towards the camera; zero where unknown; empty until estimated
  std::optional<Pose> T_world_camera;  ///< from the recording; rigid and finite

  // What masks add, of the size of `depth_m`; each is empty without.
  Image<std::uint8_t> weights;  ///< how much each depth counts when it is fused, of 255; empty: fully
  DepthImage outside_m;         ///< what a mask took out of `depth_m`: up to there, and no farther, space is free
  Image<std::uint8_t> labels;   ///< the class of each pixel, 0: none, if AcquireConfig::keeps_labels; the mask itself
                                ///< if AcquireConfig::keeps_masks
};

/// Why a frame could not be used: one word per kind, counted in the report as frames.dropped_by_reason.
enum class DropReason {
  kMissingFile,   ///< a file that the recording names does not exist
  kUnreadable,    ///< empty, truncated, not the format it claims, or larger than the limits
  kSizeMismatch,  ///< size differs from the first frame's or from the intrinsics
  kNoPose,        ///< the frame has no pose
  kBadPose,       ///< NaN, infinite or non-rigid pose
  kNoIntrinsics,  ///< this frame's camera is unknown
  kNoDepth,       ///< no valid depth pixel
  kTimestamp,     ///< time stamp not increasing
  kUnsafePath,    ///< the recording names a file outside its own folder
  kQueue,         ///< the reader was too slow for the recording's pace
};

/// "missing_file", "unreadable", "size_mismatch", "no_pose", "bad_pose", "no_intrinsics", "no_depth", "timestamp",
/// "unsafe_path", "queue".
[[nodiscard]] const char* to_string(DropReason reason);

struct FrameDropped {
  std::uint64_t sequence = 0;
  DropReason reason = DropReason::kUnreadable;
  Error error;  ///< names the file and what is wrong with it
};

struct EndOfStream {};

/// Frames of a scanner that did not arrive complete, by where they were lost.
struct LossCounters {
  std::uint64_t device = 0;     ///< the camera's own frame counter jumped
  std::uint64_t transport = 0;  ///< incomplete, marked as bad, or with lost packets
  std::uint64_t overflow = 0;   ///< more bytes than a picture has
  std::uint64_t queue = 0;      ///< the consumer was too slow
  std::uint64_t writer = 0;     ///< the recorder was too slow, or its disk full

  [[nodiscard]] std::uint64_t total() const { return device + transport + overflow + queue + writer; }
  LossCounters& operator+=(const LossCounters& other) {
    device += other.device;
    transport += other.transport;
    overflow += other.overflow;
    queue += other.queue;
    writer += other.writer;
    return *this;
  }
  friend bool operator==(const LossCounters&, const LossCounters&) = default;
};

/// What a source gives at each call: a frame, why one could not be used, the end, or the error that ended it.
using FrameEvent = std::variant<Frame, FrameDropped, EndOfStream, Error>;

}  // namespace scanknit
