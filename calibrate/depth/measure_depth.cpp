#include "calibrate/depth/measure_depth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "calibrate/depth/board_depth.h"
#include "core/rotation.h"

namespace scanknit {
namespace {

// A focal length that is wrong by a share moves the board by that share. At 0.7 m, where a board of A4 is seen, this is
// a quarter of the error of a sensor that is wrong by 1.5 % at 4 m.
constexpr double kMostFocal_share = 0.0006;
constexpr double kMostError_share = 0.0025;  // of 4 m: a sixth of the error of such a sensor
constexpr double kMostDelay_s = 0.001;
constexpr double kMostBaseline_m = 0.002;
constexpr double kMostTurn_rad = 0.2 * kDegree;

std::vector<BoardView> sharp_of(const std::vector<BoardView>& views, const CameraCalibration& calibration) {
  std::vector<BoardView> sharp;
  for (const std::size_t view : calibration.sharp) sharp.push_back(views[view]);
  return sharp;
}

/// How well the lens is known: the larger deviation of both focal lengths, as a share.
double focal_deviation(const CameraCalibration& calibration) {
  const CameraIntrinsics& k = calibration.camera.intrinsics;
  const CameraIntrinsics& sigma = calibration.deviation.intrinsics;
  return std::max(sigma.fx / std::abs(k.fx), sigma.fy / std::abs(k.fy));
}

/// A wrong lens makes a board seem nearer or farther: no error of depth is told from a lens that is not known well.
void add_bias(const DepthCalibration& fit, const CameraCalibration& lens, const CameraIntrinsics& camera,
              ScannerCamera& cameras, std::vector<std::string>& unknown) {
  if (const double focal = focal_deviation(lens); focal > kMostFocal_share) {
    unknown.push_back(
        fmt::format("the error of depth is not measured: the focal length is known to +- {:.2g} % only, "
                    "expected {:.2g} %; move the board more slowly, rest in between, take more views",
                    100 * focal, 100 * kMostFocal_share));
    return;
  }
  const DepthDeviation& far = fit.deviations.back();
  if (far.deviation_m > kMostError_share * far.distance_m) {
    unknown.push_back(
        fmt::format("the error of depth is known to +- {:.0f} mm at {:.0f} m only, expected {:.0f} mm; show "
                    "the board from near to far and in all parts of the picture (seen here: {:.2f} to "
                    "{:.2f} m)",
                    1000 * far.deviation_m, far.distance_m, 1000 * kMostError_share * far.distance_m, fit.nearest_m,
                    fit.farthest_m));
    return;
  }
  if (!cameras.depth) cameras.depth = CameraModel{camera, {}};
  cameras.depth_bias = fit.bias;
}

void add_delay(const DepthCalibration& fit, bool has_clock, ScannerCamera& cameras, std::vector<std::string>& unknown) {
  if (!has_clock) {
    unknown.emplace_back("the time between depth and colour is not measured: the recording has no time stamps");
  } else if (fit.colour_later_deviation_s > kMostDelay_s) {
    unknown.push_back(fmt::format(
        "the time between depth and colour is known to +- {:.1f} ms only, expected {:.0f} ms; move the board "
        "towards the camera and away, in a recording of which every frame is looked at (at most {} frames)",
        1000 * fit.colour_later_deviation_s, 1000 * kMostDelay_s, kMostBoardPictures));
  } else {
    cameras.colour_later_s = fit.colour_later_s;
  }
}

void add_pose(const DepthCalibration& fit, const Pose& T_colour_depth, ScannerCamera& cameras,
              std::vector<std::string>& unknown) {
  const double shift_m = fit.correction_deviation.head<3>().norm();
  const double turn_rad = fit.correction_deviation.tail<3>().norm();
  if (shift_m > kMostBaseline_m || turn_rad > kMostTurn_rad) {
    unknown.push_back(
        fmt::format("the pose between depth and colour is known to +- {:.1f} mm and {:.2f} degrees only, expected "
                    "{:.0f} mm and {:.1f} "
                    "degrees; tilt the board by 30 to 45 degrees to all sides",
                    1000 * shift_m, turn_rad / kDegree, 1000 * kMostBaseline_m, kMostTurn_rad / kDegree));
    return;
  }
  cameras.T_colour_depth = T_colour_depth * fit.correction.inverse();
}

}  // namespace

Result<MeasuredDepth> measure_depth(const std::filesystem::path& path, AcquireConfig acquire,
                                    const BoardPictures& pictures, const std::vector<BoardView>& views,
                                    const CameraCalibration& calibration, const CalibrationTarget& target,
                                    const std::stop_token& stop, ScannerCamera& cameras) {
  const bool is_registered = pictures.registered_depth.has_value();
  acquire.poses = PoseMode::kTrack;  // keeps frames without a pose
  acquire.intrinsics.reset();
  acquire.camera = is_registered ? std::make_shared<const ScannerCamera>(cameras) : nullptr;
  acquire.every = pictures.every;
  const auto depths = read_board_depths(path, acquire, sharp_of(views, calibration), calibration.camera,
                                        calibration.noise_px, target, stop);
  if (!depths) return depths.error();
  const auto between = is_registered ? DepthToColour::kKnown : DepthToColour::kEstimated;
  auto fit = fit_depth(depths->views, depths->camera, between);
  if (!fit) return fit.error();
  MeasuredDepth result{std::move(*fit), {}};
  add_bias(result.fit, calibration, depths->camera, cameras, result.unknown);
  add_delay(result.fit, depths->has_clock, cameras, result.unknown);
  if (!is_registered) add_pose(result.fit, depths->T_colour_depth, cameras, result.unknown);
  return result;
}

}  // namespace scanknit
