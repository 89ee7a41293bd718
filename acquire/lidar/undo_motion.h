// The motion of a LiDAR within a sweep, taken out of its points.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "acquire/lidar/sweep_source.h"
#include "core/pose.h"

namespace scanknit {

/// T_world_sensor at a time of the recording's clock; nothing where it is not known.
using SensorPath = std::function<std::optional<Pose>(std::int64_t time_ns)>;

/// Puts each point where it would have been measured from Sweep::T_world_sensor, the pose at Sweep::timestamp_ns, and
/// empties Sweep::offsets_ns. False, and nothing is changed, where the path does not reach over the whole sweep, or
/// leads farther within it than any scanner goes. A sweep without a clock, or without offsets, is taken as measured at
/// once.
[[nodiscard]] bool undo_motion(const SensorPath& path, Sweep& sweep);

}  // namespace scanknit
