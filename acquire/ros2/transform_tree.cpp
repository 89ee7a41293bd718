#include "acquire/ros2/transform_tree.h"

#include <algorithm>
#include <utility>

namespace scanknit {
namespace {

/// Told at least twice, and within 0.1 mm and 0.01 degrees of the first: less than depth tells at its nearest.
bool are_all_the_same(const std::vector<TimedPose>& poses) {
  constexpr double kSame_m = 1e-4, kSame_rad = 1.7e-4;
  if (poses.size() < 2 || !poses.front().pose) return false;
  const Pose T_first_parent = poses.front().pose->inverse();
  return std::all_of(poses.begin(), poses.end(), [&](const TimedPose& timed) {
    if (!timed.pose) return false;
    const Pose change = T_first_parent * *timed.pose;
    return change.translation().norm() < kSame_m && Eigen::AngleAxisd(change.linear()).angle() < kSame_rad;
  });
}

}  // namespace

void TransformTree::add(Ros2Transform transform, bool is_static) {
  constexpr std::size_t kMaxFrames = 1000;
  if (edges_.size() >= kMaxFrames && !edges_.contains(transform.child)) return;
  const auto [place, is_new] = edges_.try_emplace(std::move(transform.child));
  Edge& edge = place->second;
  if (is_new) {
    edge.parent = std::move(transform.parent);
    edge.is_static = is_static;
  } else if (edge.parent != transform.parent || edge.is_static != is_static) {
    return;
  }
  if (is_static) edge.poses.clear();  // the last one holds
  edge.poses.push_back({transform.stamp_ns, std::move(transform.T_parent_child)});
}

void TransformTree::sort() {
  for (auto& [child, edge] : edges_) {
    sort_by_time(edge.poses);
    edge.never_changes = edge.is_static || are_all_the_same(edge.poses);
  }
}

std::vector<std::string> TransformTree::path_up(std::string frame, bool only_unchanging) const {
  std::vector<std::string> path{std::move(frame)};
  // A circle, which is no tree, ends after so many steps.
  while (path.size() <= edges_.size()) {
    const auto edge = edges_.find(path.back());
    if (edge == edges_.end() || (only_unchanging && !edge->second.never_changes)) break;
    path.push_back(edge->second.parent);
  }
  return path;
}

std::string TransformTree::root_of(const std::string& frame) const {
  return path_up(frame, false).back();
}

bool TransformTree::is_moving(const std::string& frame) const {
  const auto path = path_up(frame, false);
  return std::any_of(path.begin(), path.end() - 1,
                     [&](const std::string& child) { return !edges_.at(child).is_static; });
}

std::optional<std::string> TransformTree::moves_elsewhere(const std::string& frame) const {
  const std::string root = root_of(frame);
  for (const auto& [child, edge] : edges_) {
    if (!edge.never_changes && root_of(child) != root) return edge.parent + " -> " + child;
  }
  return std::nullopt;
}

std::optional<Result<Pose>> TransformTree::pose_in_root(const std::string& frame, std::int64_t time_ns) const {
  auto path = path_up(frame, false);
  path.pop_back();
  const auto told = [&](const std::string& child) {
    const Edge& edge = edges_.at(child);
    return edge.never_changes ? 0 : edge.poses.size();
  };
  const auto moving =
      std::max_element(path.begin(), path.end(), [&](const auto& a, const auto& b) { return told(a) < told(b); });
  Pose T_parent_frame = Pose::Identity();
  for (auto child = path.begin(); child != path.end(); ++child) {
    const Edge& edge = edges_.at(*child);
    const auto T_parent_child = edge.never_changes ? std::optional(edge.poses.back().pose)
                                : child == moving  ? pose_at(edge.poses, time_ns)
                                                   : slow_pose_at(edge, time_ns);
    if (!T_parent_child || !*T_parent_child) return T_parent_child;
    T_parent_frame = **T_parent_child * T_parent_frame;
  }
  return Result<Pose>(T_parent_frame);
}

std::optional<Result<Pose>> TransformTree::slow_pose_at(const Edge& edge, std::int64_t time_ns) {
  constexpr std::int64_t kLongestGap_ns = 10'000'000'000;  // what tf2's buffer keeps
  constexpr std::int64_t kHolds_ns = 1'000'000'000;        // the usual interval of a map's corrections
  if (auto pose = pose_at(edge.poses, time_ns, kLongestGap_ns)) return pose;
  const TimedPose &first = edge.poses.front(), &last = edge.poses.back();
  if (time_ns < first.time_ns && distance_ns(first.time_ns, time_ns) <= kHolds_ns) return first.pose;
  if (time_ns > last.time_ns && distance_ns(last.time_ns, time_ns) <= kHolds_ns) return last.pose;
  return std::nullopt;
}

std::optional<Pose> TransformTree::between(const std::string& a, const std::string& b) const {
  const auto path_a = path_up(a, true);
  const auto path_b = path_up(b, true);
  const auto common = std::find_first_of(path_a.begin(), path_a.end(), path_b.begin(), path_b.end());
  if (common == path_a.end()) return std::nullopt;
  const auto climb = [&](const std::vector<std::string>& path) -> std::optional<Pose> {
    Pose T_common_frame = Pose::Identity();
    for (auto frame = path.begin(); frame != path.end() && *frame != *common; ++frame) {
      const Result<Pose>& T_parent_child = edges_.at(*frame).poses.back().pose;
      if (!T_parent_child) return std::nullopt;
      T_common_frame = *T_parent_child * T_common_frame;
    }
    return T_common_frame;
  };
  const auto T_common_a = climb(path_a);
  const auto T_common_b = climb(path_b);
  if (!T_common_a || !T_common_b) return std::nullopt;
  return T_common_a->inverse() * *T_common_b;
}

}  // namespace scanknit
