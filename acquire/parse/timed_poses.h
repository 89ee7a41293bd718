// The pose of a camera at any time of a trajectory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "core/limits.h"
#include "core/pose.h"
#include "core/result.h"

namespace scanknit {

/// What lies within so much of a time is of that time: what the TUM benchmark's own association script allows.
inline constexpr std::int64_t kMaxDifference_ns = 20'000'000;

/// The distance of two times, 2^63 - 1 where it does not fit 64 bits.
[[nodiscard]] std::int64_t distance_ns(std::int64_t a, std::int64_t b);

struct TimedPose {
  std::int64_t time_ns = 0;
  Result<Pose> pose;  ///< an Error: why the recorded one is invalid
};

/// Poses of one time keep their order.
void sort_by_time(std::vector<TimedPose>& poses);

/// A file of lines "seconds tx ty tz qx qy qz qw", sorted by time; a pose that is none is an Error. Errors (kInput): it
/// cannot be read; a line does not begin with a time.
[[nodiscard]] Result<std::vector<TimedPose>> read_tum_poses(const std::filesystem::path& path, const Limits& limits);

/// 10 poses a second are dense enough to interpolate.
inline constexpr std::int64_t kMaxGap_ns = 100'000'000;

/// The pose at `time_ns`, of `poses` sorted by time: interpolated between its neighbours where these are at most
/// `max_gap_ns` apart or one of them is within kMaxDifference_ns; beyond an end the last one, within kMaxDifference_ns.
/// Nothing where there is none.
[[nodiscard]] std::optional<Result<Pose>> pose_at(const std::vector<TimedPose>& poses, std::int64_t time_ns,
                                                  std::int64_t max_gap_ns = kMaxGap_ns);

}  // namespace scanknit
