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

/// How well one frame was tracked, of the report's `tracking.frames`.
struct TrackedFrameShares {
  double overlap = 0, inlier_share = 0;
  std::string state;
};

/// One column for each frame, or for some in a row, of which the worst is drawn. 100 units are 100 %, upwards from y =
/// 100.
struct TrackingChart {
  std::vector<std::string_view> states;  ///< of the columns: "ok", "recovered", "weak" or "lost"
  std::string overlap, inliers;          ///< points of lines, one a column
};
[[nodiscard]] TrackingChart tracking_chart(std::span<const TrackedFrameShares> frames);

/// Where the camera was, of a trajectory in the TUM format; what is no pose is left out. Of many poses only some,
/// evenly.
[[nodiscard]] std::vector<Eigen::Vector3d> camera_positions(std::string_view trajectory);

/// The way of the camera, seen along an axis, in a square of 100 units.
struct PathDrawing {
  struct Box {
    double x, y, width, height;
  };
  std::optional<Box> mesh;      ///< nothing for an empty box
  std::string points;           ///< of the line
  Eigen::Vector2d first, last;  ///< where the way begins and ends
  double side_m = 0;            ///< of the square
};

/// `right` and `down` are the numbers of the axes that point there. `positions` is not empty.
[[nodiscard]] PathDrawing draw_path(const std::vector<Eigen::Vector3d>& positions, const Eigen::AlignedBox3d& mesh,
                                    int right, int down);

}  // namespace scanknit
