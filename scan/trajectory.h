// Trajectory: the poses of a scan's frames.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "core/frame.h"
#include "core/pose.h"
#include "fusion/shutter/frame_motion.h"

namespace scanknit {

/// A frame that was fused.
struct PosedFrame {
  std::uint64_t sequence = 0;  ///< Frame::sequence
  double stamp = 0;            ///< seconds of the recording's clock; the frame's number if it has no clock
  Pose T_world_camera = Pose::Identity();
  FrameMotion motion = {};
};

/// In the order in which they were fused.
using Trajectory = std::vector<PosedFrame>;

/// T_world_camera by Frame::sequence.
using PosesBySequence = std::map<std::uint64_t, Pose>;

[[nodiscard]] inline PosesBySequence poses_of(const Trajectory& trajectory) {
  PosesBySequence poses;
  for (const PosedFrame& frame : trajectory) poses[frame.sequence] = frame.T_world_camera;
  return poses;
}

/// The frame's PosedFrame::stamp.
[[nodiscard]] inline double stamp_of(const Frame& frame) {
  return frame.has_clock ? static_cast<double>(frame.timestamp_ns) * 1e-9 : static_cast<double>(frame.sequence);
}

}  // namespace scanknit
