// A camera's lens from pictures of a board.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "acquire/acquire_config.h"
#include "calibrate/board/find_board.h"
#include "calibrate/lens/bundle.h"
#include "calibrate/target/calibration_target.h"
#include "core/result.h"

namespace scanknit {

/// A picture in which the board was found.
struct BoardView {
  std::string picture;  ///< its name, for messages
  std::vector<SeenCorner> corners;
  double sharpness = 0;  ///< BoardSighting::sharpness
};

/// Its corners, for an estimate. `corners_m`: target_corners() of its board.
[[nodiscard]] BundleView bundle_view(const BoardView& view, const std::vector<Eigen::Vector2d>& corners_m);

struct PictureSize {
  int width = 0, height = 0;
};

/// One view that the lens was estimated from.
struct UsedView {
  std::string picture;
  std::size_t corners = 0;
  double error_px = 0;  ///< root mean square of the distances between seen and projected corners
};

struct CameraCalibration {
  CameraModel camera;
  /// Standard deviations of the numbers of `camera` (width and height 0), as the residuals tell them; 0 for a k3 that
  /// was not estimated. An error of the printed board is not in them.
  CameraModel deviation;
  double error_px = 0;  ///< root mean square of the distances between seen and projected corners
  double noise_px = 0;  ///< standard deviation of a corner's coordinate: from the residuals, less what was estimated
  std::size_t corners = 0;
  std::vector<UsedView> views;
  std::vector<std::size_t> sharp;                        ///< places in the caller's list, of all views that are sharp
  std::size_t blurred = 0, outlying = 0, redundant = 0;  ///< views that were left out
  std::size_t outlying_corners = 0;
  double covered = 0;  ///< share of the picture's 8 x 6 parts in which a corner was seen
};

/// The views that are not much less sharp than the sharpest tenth, by their places.
[[nodiscard]] std::vector<std::size_t> sharp_views(const std::vector<BoardView>& views);

/// The fewest sharp views.
inline constexpr std::size_t kFewestViews = 8;

/// Estimates fx, fy, cx, cy, k1, k2, p1, p2, and k3 where the residuals ask for it. Blurred views and outliers are left
/// out; of the others those are taken that tell the most, at most 60. `target` is valid. Deterministic.
/// Errors (kTooLittle): fewer than kFewestViews sharp views; views that are too alike to tell the focal length; a lens
/// that does not explain the views.
[[nodiscard]] Result<CameraCalibration> calibrate_camera(const std::vector<BoardView>& views,
                                                         const CalibrationTarget& target, PictureSize size);

}  // namespace scanknit
