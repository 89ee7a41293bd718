// BoardTrack: the board before one camera of a rig, at any time.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "calibrate/board/find_board.h"
#include "calibrate/lens/lens.h"
#include "calibrate/target/calibration_target.h"
#include "core/pose.h"

namespace scanknit {

/// The board in one picture.
struct TimedView {
  double time_s = 0;  ///< by the camera's clock
  std::vector<SeenCorner> corners;
};

struct MovingCorner {
  SeenCorner corner;
  Eigen::Vector2d pixels_per_s = Eigen::Vector2d::Zero();
};

class BoardTrack {
 public:
  /// Between pictures that are further apart, nothing is known of the board.
  static constexpr double kLongestGap_s = 0.25;

  /// `views` in the order of their times, at least one; of at least four corners each.
  BoardTrack(std::vector<TimedView> views, const LensVector& lens, const CalibrationTarget& target);

  [[nodiscard]] const std::vector<TimedView>& views() const { return views_; }
  /// T_camera_board of each view.
  [[nodiscard]] const std::vector<Pose>& poses() const { return poses_; }
  /// The usual time between two views; 0 of one view.
  [[nodiscard]] double period_s() const { return period_s_; }

  /// The corners that are seen before and after `time_s`: by a cubic through four views where there are four, else by a
  /// line. At the time of a view, all of its corners; those whose motion is unknown as if they stood still.
  [[nodiscard]] std::vector<MovingCorner> corners_at(double time_s) const;
  /// T_camera_board; nothing where it is unknown.
  [[nodiscard]] std::optional<Pose> pose_at(double time_s) const;

 private:
  [[nodiscard]] std::size_t last_until(double time_s) const;
  [[nodiscard]] bool are_near(std::size_t view, std::size_t next) const;
  [[nodiscard]] std::optional<MovingCorner> corner_at(double time_s, std::size_t view, int number) const;

  std::vector<TimedView> views_;
  std::vector<Pose> poses_;
  double period_s_ = 0;
};

}  // namespace scanknit
