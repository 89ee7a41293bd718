// The geometry of the drawings in report.html: points of SVG, in the units of their view boxes.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace scanknit {

/// How well one frame was tracked, from the report's `tracking.frames`.
struct TrackedFrameShares {
  double overlap = 0, inlier_share = 0;
  std::string state;
};

/// One column for each frame, or for several in a row, of which it draws the worst. 100 units are 100 %, upwards from y
/// = 100.
struct TrackingChart {
  std::vector<std::string_view> states;  ///< of the columns: "ok", "recovered", "weak" or "lost"
  std::string overlap, inliers;          ///< points of polylines, one for each column
};
[[nodiscard]] TrackingChart tracking_chart(std::span<const TrackedFrameShares> frames);

/// The camera's positions from a trajectory in the TUM format. Skips lines that are no pose. Of many poses it takes
/// only some, evenly spread.
[[nodiscard]] std::vector<Eigen::Vector3d> camera_positions(std::string_view trajectory);

/// The camera's path, seen along an axis, in a square of 100 units.
struct PathDrawing {
  struct Box {
    double x, y, width, height;
  };
  std::optional<Box> mesh;      ///< nothing for an empty box
  std::string points;           ///< points of the polyline
  Eigen::Vector2d first, last;  ///< the path's ends
  double side_m = 0;            ///< side of the square
};

/// `right` and `down` are the numbers of the axes that point there. `positions` is not empty.
[[nodiscard]] PathDrawing draw_path(const std::vector<Eigen::Vector3d>& positions, const Eigen::AlignedBox3d& mesh,
                                    int right, int down);

}  // namespace scanknit
