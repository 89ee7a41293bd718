#include "app/live/tracking_watch.h"

#include <utility>

#include "core/frame_timing.h"
#include "core/pixels/typical_depth.h"

namespace scanknit {
namespace {

// Turning and moving together, as an angle of what is seen. In the quick turn of test_tracking_watch.cpp the first
// frame is lost at 1.5.
constexpr double kFast_rad_per_s = 1.0;
constexpr double kLongest_s = 0.15;  // over a longer time the mean motion says little

// Twice the share of the picture that tracking needs.
constexpr double kFewPoints = 0.06;
constexpr double kClose_m = 0.7;  // nearer than this most depth cameras see nothing

}  // namespace

std::optional<TrackingCaution> TrackingWatch::look(const Frame& frame, const Pose& T_world_camera, std::size_t points) {
  const auto before = std::exchange(last_, Last{T_world_camera, frame.timestamp_ns});
  const auto depth_m = static_cast<double>(typical_depth_m(frame.depth_m));
  if (before && frame.has_clock && depth_m > 0) {
    const double since_s = static_cast<double>(frame.timestamp_ns - before->timestamp_ns) * 1e-9;
    const auto motion = SteadyMotion::from(before->T_world_camera.inverse() * T_world_camera);
    const double angle_rad = motion.turn_rad.norm() + motion.shift_m.norm() / depth_m;
    if (since_s > 0 && since_s <= kLongest_s && angle_rad > kFast_rad_per_s * since_s) {
      return TrackingCaution{"moving fast", "move more slowly"};
    }
  }
  const auto pixels = static_cast<double>(frame.intrinsics.width) * frame.intrinsics.height;
  if (static_cast<double>(points) >= kFewPoints * pixels) return std::nullopt;
  if (depth_m < kClose_m) return TrackingCaution{"very close", "step back a little"};
  return TrackingCaution{"little is seen", "show more of the object or the room"};
}

}  // namespace scanknit
