// sensor_msgs/PointCloud2 as a sweep of a LiDAR.
#pragma once

#include <cstdint>

#include "acquire/bag/ros_message.h"
#include "acquire/lidar/sweep_source.h"
#include "core/limits.h"
#include "core/result.h"

namespace scanknit {

/// The returns of a cloud, without pose and number, at `stamp_ns`, the time in its header. Fields that are read:
///   x y z                       floating point, metres; returns only (lidar_return.h)
///   ring, channel               which laser, unsigned; left out where a number is beyond 65535
///   t time timestamp time_stamp offset_time
///                               when: nanoseconds after the stamp (32 bits unsigned); seconds or nanoseconds after it,
///                               before it where they are negative, or since the epoch (floating point). Which of these
///                               it is, the values tell: the one in which they are nearest to the stamp. Left out where
///                               that is more than two seconds, and where the sweep would last less than a millisecond.
/// Errors (kInput, without `where`): truncated; no such x y z; contradicting itself about its size; more points than a
/// picture may have pixels.
[[nodiscard]] Result<Sweep> decode_cloud_sweep(const RosMessage& message, std::int64_t stamp_ns, const Limits& limits);

}  // namespace scanknit
