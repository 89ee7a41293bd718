// TransformTree: where the frames of reference of a robot are (tf2: T. Foote 2013).
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "acquire/parse/timed_poses.h"
#include "acquire/ros2/ros2_messages.h"
#include "core/pose.h"

namespace scanknit {

/// Frames form trees: each has at most one parent, the first that is told.
class TransformTree {
 public:
  /// `is_static`: it holds at all times.
  void add(Ros2Transform transform, bool is_static);
  /// To be called after the last add(), before the tree is asked.
  void sort();

  [[nodiscard]] bool has_parent(const std::string& frame) const { return edges_.contains(frame); }

  /// The frame that is reached from `frame` over all parents; `frame` itself where it has none.
  [[nodiscard]] std::string root_of(const std::string& frame) const;

  /// True if some transform between `frame` and its root is not static.
  [[nodiscard]] bool is_moving(const std::string& frame) const;

  /// A frame that moves in a tree to which `frame` does not belong: "map -> base". Nothing where there is none.
  [[nodiscard]] std::optional<std::string> moves_elsewhere(const std::string& frame) const;

  /// T_root_frame at a time; an Error where a transform on the way is invalid; nothing where one has no pose then. The
  /// transform on the way that is told most often is the one that moves: it is followed as pose_at() does. The others
  /// are slow (a map's corrections once a second, a mount that is told again and again): they are interpolated over up
  /// to ten seconds, as tf2 does, and hold for a second beyond their ends. One that never changes holds at all times.
  [[nodiscard]] std::optional<Result<Pose>> pose_in_root(const std::string& frame, std::int64_t time_ns) const;

  /// T_a_b, where only transforms that never change lie between them.
  [[nodiscard]] std::optional<Pose> between(const std::string& a, const std::string& b) const;

 private:
  struct Edge {
    std::string parent;
    bool is_static = false;
    bool never_changes = false;  ///< static, or told several times and always the same
    std::vector<TimedPose> poses;
  };
  /// The frames from `frame` to its root, or to the first whose transform changes.
  [[nodiscard]] std::vector<std::string> path_up(std::string frame, bool only_unchanging) const;
  [[nodiscard]] static std::optional<Result<Pose>> slow_pose_at(const Edge& edge, std::int64_t time_ns);

  std::map<std::string, Edge> edges_;  ///< by the child
};

}  // namespace scanknit
