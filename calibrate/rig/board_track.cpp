#include "calibrate/rig/board_track.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "calibrate/lens/first_guess.h"
#include "core/median.h"

namespace scanknit {
namespace {

constexpr double kSameTime_s = 1e-4;

const SeenCorner* find_corner(const TimedView& view, int number) {
  const auto at = std::ranges::lower_bound(view.corners, number, {}, &SeenCorner::number);
  return at != view.corners.end() && at->number == number ? &*at : nullptr;
}

struct SeenAt {
  double time_s = 0;
  const SeenCorner* corner = nullptr;
};

Eigen::Vector2d speed_between(const SeenAt& from, const SeenAt& to) {
  return (to.corner->pixel - from.corner->pixel) / (to.time_s - from.time_s);
}

/// The place on the polynomial through the corners (Lagrange).
Eigen::Vector2d place_through(const std::vector<SeenAt>& seen, double time_s) {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < seen.size(); ++i) {
    double weight = 1;
    for (std::size_t k = 0; k < seen.size(); ++k) {
      if (k != i) weight *= (time_s - seen[k].time_s) / (seen[i].time_s - seen[k].time_s);
    }
    place += weight * seen[i].corner->pixel;
  }
  return place;
}

}  // namespace

BoardTrack::BoardTrack(std::vector<TimedView> views, const LensVector& lens, const CalibrationTarget& target)
    : views_(std::move(views)) {
  const std::vector<Eigen::Vector2d> corners_m = target_corners(target);
  std::vector<double> gaps;
  for (std::size_t i = 0; i < views_.size(); ++i) {
    BundleView view;
    for (const SeenCorner& corner : views_[i].corners) {
      view.board_m.push_back(corners_m[static_cast<std::size_t>(corner.number)]);
      view.pixels.push_back(corner.pixel);
    }
    poses_.push_back(guess_pose(lens, view));
    if (i > 0) gaps.push_back(views_[i].time_s - views_[i - 1].time_s);
  }
  if (!gaps.empty()) period_s_ = median(gaps);
}

/// The last view that is not after `time_s`, or the first.
std::size_t BoardTrack::last_until(double time_s) const {
  const auto after = std::ranges::upper_bound(views_, time_s, {}, &TimedView::time_s);
  return after == views_.begin() ? 0 : static_cast<std::size_t>(after - views_.begin()) - 1;
}

bool BoardTrack::are_near(std::size_t view, std::size_t next) const {
  return next < views_.size() && views_[next].time_s - views_[view].time_s <= kLongestGap_s;
}

/// Between `view` and the next. The speed is from differences round each of both: where the place is that of a view,
/// its noise is not in the speed, else the product of both would move the estimate of the clock.
std::optional<MovingCorner> BoardTrack::corner_at(double time_s, std::size_t view, int number) const {
  const auto seen_in = [&](std::size_t at) { return SeenAt{views_[at].time_s, find_corner(views_[at], number)}; };
  const SeenAt from = seen_in(view), to = seen_in(view + 1);
  if (from.corner == nullptr || to.corner == nullptr) return std::nullopt;
  if (view > 0 && are_near(view - 1, view) && are_near(view + 1, view + 2)) {
    const SeenAt before = seen_in(view - 1), after = seen_in(view + 2);
    if (before.corner != nullptr && after.corner != nullptr) {
      const double share = (time_s - from.time_s) / (to.time_s - from.time_s);
      return MovingCorner{{number, place_through({before, from, to, after}, time_s)},
                          (1 - share) * speed_between(before, to) + share * speed_between(from, after)};
    }
  }
  return MovingCorner{{number, place_through({from, to}, time_s)}, speed_between(from, to)};
}

std::vector<MovingCorner> BoardTrack::corners_at(double time_s) const {
  std::vector<MovingCorner> result;
  std::size_t view = last_until(time_s + kSameTime_s);
  const bool is_at_view = std::abs(views_[view].time_s - time_s) <= kSameTime_s;
  const bool is_last = !are_near(view, view + 1);
  if (is_at_view && is_last && view > 0 && are_near(view - 1, view)) --view;  // its motion is that from the one before
  const bool has_motion = are_near(view, view + 1) && time_s >= views_[view].time_s - kSameTime_s &&
                          time_s <= views_[view + 1].time_s + kSameTime_s;
  const TimedView& here = is_at_view && is_last && has_motion ? views_[view + 1] : views_[view];
  for (const SeenCorner& corner : here.corners) {
    const auto moving = has_motion ? corner_at(time_s, view, corner.number) : std::nullopt;
    if (moving) result.push_back(*moving);
    if (!moving && is_at_view) result.push_back({corner});
  }
  return result;
}

std::optional<Pose> BoardTrack::pose_at(double time_s) const {
  const std::size_t view = last_until(time_s + kSameTime_s);
  const double after_s = time_s - views_[view].time_s;
  if (std::abs(after_s) <= kSameTime_s) return poses_[view];
  if (after_s < 0 || !are_near(view, view + 1)) return std::nullopt;
  const double share = after_s / (views_[view + 1].time_s - views_[view].time_s);
  const Pose& from = poses_[view];
  const Pose& to = poses_[view + 1];
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::Quaterniond(from.linear()).slerp(share, Eigen::Quaterniond(to.linear())).toRotationMatrix();
  pose.translation() = (1 - share) * from.translation() + share * to.translation();
  return pose;
}

}  // namespace scanknit
