// TrajectoryFile: the poses of a recording's frames, from a file beside it.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <vector>

#include "acquire/parse/timed_poses.h"
#include "core/frame.h"
#include "core/limits.h"
#include "core/pose.h"
#include "core/result.h"

namespace scanknit {

/// What `run --trajectory` and trajectory_text() write, and what others write in these formats. A pose belongs to a
/// frame by its stamp: seconds of the recording's clock, or the frame's number if it has none. KITTI's poses have no
/// stamps: line n is that of frame n.
class TrajectoryFile {
 public:
  /// By the path's ending: `.kitti`, `.json`, else TUM's. Errors (kInput): it cannot be read, has no pose, or is of
  /// another format.
  [[nodiscard]] static Result<TrajectoryFile> read(const std::filesystem::path& path, const Limits& limits);

  /// The pose of a frame; nothing if there is none, an Error if that is no pose. `place`: the frame's place in the
  /// recording, from 0. Between stamps of a clock it is interpolated as pose_at() does.
  [[nodiscard]] std::optional<Result<Pose>> pose_of(const Frame& frame, std::size_t place) const;

  /// The number of poses if each belongs to a frame by its place.
  [[nodiscard]] std::optional<std::size_t> count_by_place() const;

 private:
  std::vector<Result<Pose>> by_place_;       ///< KITTI's
  std::vector<TimedPose> by_time_;           ///< sorted
  std::map<double, std::size_t> by_number_;  ///< of by_time_, by stamp as a number
};

}  // namespace scanknit
