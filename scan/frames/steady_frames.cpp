#include "scan/frames/steady_frames.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/check.h"

namespace scanknit {
namespace {

/// Speed of the point one metre in front of the camera, in metres per frame number. Measured from the frame before to
/// the frame after; these are farther apart where frames are missing.
double speed_m(const Trajectory& frames, std::size_t i) {
  const Eigen::Vector3d ahead = Eigen::Vector3d::UnitZ();
  const PosedFrame& before = frames[i == 0 ? 0 : i - 1];
  const PosedFrame& after = frames[std::min(i + 1, frames.size() - 1)];
  if (before.sequence == after.sequence) return 0;  // there is only one frame
  const double moved_m = (after.T_world_camera * ahead - before.T_world_camera * ahead).norm();
  return moved_m / static_cast<double>(after.sequence - before.sequence);
}

}  // namespace

PosesBySequence steadiest(const PosesBySequence& T_world_camera, std::size_t most) {
  SCANKNIT_CHECK(most > 0);
  Trajectory frames;
  for (const auto& [sequence, pose] : T_world_camera) frames.push_back({.sequence = sequence, .T_world_camera = pose});
  const std::size_t group = (frames.size() + most - 1) / most;
  PosesBySequence chosen;
  for (std::size_t begin = 0; begin < frames.size(); begin += group) {
    std::size_t best = begin;
    for (std::size_t i = begin; i < std::min(begin + group, frames.size()); ++i) {
      if (speed_m(frames, i) < speed_m(frames, best)) best = i;
    }
    chosen.emplace(frames[best].sequence, frames[best].T_world_camera);
  }
  return chosen;
}

}  // namespace scanknit
