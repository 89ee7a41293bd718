#include "calibrate/calibrate_camera.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "calibrate/lens/bundle.h"
#include "calibrate/lens/choose_views.h"
#include "calibrate/lens/first_guess.h"
#include "core/median.h"

namespace scanknit {
namespace {

constexpr double kHuber_px = 1;
constexpr std::size_t kMostViews = 60;

Error too_little(std::string message) {
  return {ErrorCode::kTooLittle, std::move(message)};
}

/// The estimate, and which view of the caller each of its views is.
struct Estimate {
  Bundle bundle;
  std::vector<std::size_t> views;
};

/// From some of the views, evenly spaced.
LensVector rough_lens(const std::vector<BundleView>& views, PictureSize size) {
  Bundle bundle;
  const std::size_t step = (views.size() + kMostViews - 1) / kMostViews;
  for (std::size_t i = 0; i < views.size(); i += step) bundle.views.push_back(views[i]);
  bundle.lens = guess_lens(bundle.views, size.width, size.height);
  for (BundleView& view : bundle.views) view.T_camera_board = guess_pose(bundle.lens, view);
  for (const FreeLens free : {FreeLens::kTwoRadial, FreeLens::kWithoutK3}) optimise(bundle, free, kHuber_px);
  return bundle.lens;
}

Estimate first_estimate(const std::vector<BoardView>& views, const std::vector<std::size_t>& sharp,
                        const CalibrationTarget& target, PictureSize size) {
  const std::vector<Eigen::Vector2d> corners_m = target_corners(target);
  std::vector<BundleView> all;
  for (const std::size_t view : sharp) all.push_back(bundle_view(views[view], corners_m));
  Estimate estimate;
  estimate.bundle.lens = rough_lens(all, size);
  std::vector<LensMatrix> informations;
  for (BundleView& view : all) {
    view.T_camera_board = guess_pose(estimate.bundle.lens, view);
    informations.push_back(information(estimate.bundle.lens, view, FreeLens::kWithoutK3));
  }
  for (const std::size_t chosen : choose_views(informations, kMostViews)) {
    estimate.bundle.views.push_back(all[chosen]);
    estimate.views.push_back(sharp[chosen]);
  }
  optimise(estimate.bundle, FreeLens::kWithoutK3, kHuber_px);
  return estimate;
}

double error_of(const std::vector<Eigen::Vector2d>& residuals) {
  double squares = 0;
  for (const Eigen::Vector2d& residual : residuals) squares += residual.squaredNorm();
  return std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, residuals.size())));
}

/// Takes out corners that are far from where they should be, and then views that fit much worse than the others.
void drop_outliers(Estimate& estimate, CameraCalibration& result) {
  // The median of the lengths of two normal coordinates is 1.1774 deviations (Rayleigh); 5 are exceeded by 4 in a
  // million.
  constexpr double kMedianInDeviations = 1.1774, kMostDeviations = 5, kMostOfAView = 3;
  std::vector<double> lengths;
  for (const BundleView& view : estimate.bundle.views) {
    for (const Eigen::Vector2d& residual : residuals(estimate.bundle.lens, view)) lengths.push_back(residual.norm());
  }
  const double usual_px = median(lengths) / kMedianInDeviations;
  Estimate kept{{estimate.bundle.lens, {}}, {}};
  for (std::size_t i = 0; i < estimate.views.size(); ++i) {
    const BundleView& view = estimate.bundle.views[i];
    const auto errors = residuals(estimate.bundle.lens, view);
    BundleView fitting;
    fitting.T_camera_board = view.T_camera_board;
    std::vector<double> lengths_of_view;
    for (std::size_t k = 0; k < errors.size(); ++k) {
      lengths_of_view.push_back(errors[k].norm());
      if (!(errors[k].norm() <= kMostDeviations * usual_px)) continue;
      fitting.board_m.push_back(view.board_m[k]);
      fitting.pixels.push_back(view.pixels[k]);
    }
    const bool fits = median(lengths_of_view) <= kMostOfAView * kMedianInDeviations * usual_px &&
                      fitting.pixels.size() >= kFewestCorners;
    result.outlying += fits ? 0 : 1;
    if (!fits) continue;
    result.outlying_corners += errors.size() - fitting.pixels.size();
    kept.bundle.views.push_back(std::move(fitting));
    kept.views.push_back(estimate.views[i]);
  }
  estimate = std::move(kept);
}

double squares_of(const Bundle& bundle) {
  double squares = 0;
  for (const BundleView& view : bundle.views) {
    for (const Eigen::Vector2d& residual : residuals(bundle.lens, view)) squares += residual.squaredNorm();
  }
  return squares;
}

double corners_of(const Bundle& bundle) {
  double corners = 0;
  for (const BundleView& view : bundle.views) corners += static_cast<double>(view.pixels.size());
  return corners;
}

/// The variance of a coordinate: what is left of the squares for each degree of freedom.
double variance_of(const Bundle& bundle, FreeLens free) {
  const double known = 2 * corners_of(bundle);
  const double estimated = static_cast<double>(free) + 6 * static_cast<double>(bundle.views.size());
  return squares_of(bundle) / std::max(1.0, known - estimated);
}

/// Estimates without k3, and with it; keeps it if it takes away more than chance would: nine variances, three
/// deviations.
FreeLens finish(Bundle& bundle) {
  optimise(bundle, FreeLens::kWithoutK3);
  Bundle with_k3 = bundle;
  optimise(with_k3, FreeLens::kAll);
  constexpr double kMoreThanChance = 9;
  const double gained = squares_of(bundle) - squares_of(with_k3);
  if (!(gained > kMoreThanChance * variance_of(with_k3, FreeLens::kAll))) return FreeLens::kWithoutK3;
  bundle = std::move(with_k3);
  return FreeLens::kAll;
}

LensVector deviations_of(const Bundle& bundle, FreeLens free) {
  LensMatrix all = LensMatrix::Zero();
  for (const BundleView& view : bundle.views) all += information(bundle.lens, view, free);
  const auto held = 9 - static_cast<Eigen::Index>(free);
  all.diagonal().tail(held).setOnes();
  const LensVector units = all.diagonal().cwiseSqrt().cwiseInverse();  // else the numbers of fx and k2 are 1e10 apart
  const LensMatrix covariance = LensMatrix(units.asDiagonal() * all * units.asDiagonal()).inverse();
  LensVector deviations =
      (variance_of(bundle, free) * covariance.diagonal()).cwiseMax(0.0).cwiseSqrt().cwiseProduct(units);
  deviations.tail(held).setZero();
  return deviations;
}

/// The share of parts of the picture with a corner.
double covered_by(const Bundle& bundle, PictureSize size) {
  constexpr int kColumns = 8, kRows = 6;
  std::array<bool, kColumns * kRows> is_seen{};
  for (const BundleView& view : bundle.views) {
    for (const Eigen::Vector2d& pixel : view.pixels) {
      const int column = std::clamp(static_cast<int>(pixel.x() * kColumns / size.width), 0, kColumns - 1);
      const int row = std::clamp(static_cast<int>(pixel.y() * kRows / size.height), 0, kRows - 1);
      is_seen[static_cast<std::size_t>(row * kColumns + column)] = true;
    }
  }
  return static_cast<double>(std::count(is_seen.begin(), is_seen.end(), true)) / (kColumns * kRows);
}

/// The largest angle between a view's board and the mean of all, degrees.
double spread_of_tilts(const Bundle& bundle) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const BundleView& view : bundle.views) mean += view.T_camera_board.linear().col(2);
  double least = 1;
  for (const BundleView& view : bundle.views) {
    least = std::min(least, mean.normalized().dot(view.T_camera_board.linear().col(2)));
  }
  return std::acos(std::clamp(least, -1.0, 1.0)) * 180 / std::numbers::pi;
}

Result<void> check(const Bundle& bundle, const CameraCalibration& result, PictureSize size) {
  constexpr double kLeastSpread_degrees = 10, kMostDeviation = 0.01, kMostError = 0.01;
  const double spread = spread_of_tilts(bundle);
  const CameraIntrinsics& k = result.camera.intrinsics;
  const CameraIntrinsics& sigma = result.deviation.intrinsics;
  const double unsure = std::max(sigma.fx / std::abs(k.fx), sigma.fy / std::abs(k.fy));
  if (spread < kLeastSpread_degrees || !(unsure <= kMostDeviation)) {
    return too_little(
        fmt::format("the views are too alike: the board's directions differ by {:.0f} degrees and the focal length is "
                    "known to {:.2g} %, expected {:.0f} degrees and {:.0f} %; tilt the board to all sides by 30 to 45 "
                    "degrees",
                    spread, 100 * unsure, kLeastSpread_degrees, 100 * kMostDeviation));
  }
  if (!(result.error_px <= kMostError * size.width)) {
    return too_little(
        fmt::format("no lens explains the views: the corners are {:.1f} pixels from where it puts them; "
                    "check that target.yaml is that of the board and that the board is flat",
                    result.error_px));
  }
  return {};
}

void describe(const Estimate& estimate, const std::vector<BoardView>& views, CameraCalibration& result) {
  double squares = 0;
  for (std::size_t i = 0; i < estimate.views.size(); ++i) {
    const auto errors = residuals(estimate.bundle.lens, estimate.bundle.views[i]);
    const double error_px = error_of(errors);
    result.views.push_back({views[estimate.views[i]].picture, errors.size(), error_px});
    result.corners += errors.size();
    squares += error_px * error_px * static_cast<double>(errors.size());
  }
  result.error_px = std::sqrt(squares / static_cast<double>(result.corners));
}

}  // namespace

BundleView bundle_view(const BoardView& view, const std::vector<Eigen::Vector2d>& corners_m) {
  BundleView result;
  for (const SeenCorner& corner : view.corners) {
    result.board_m.push_back(corners_m[static_cast<std::size_t>(corner.number)]);
    result.pixels.push_back(corner.pixel);
  }
  return result;
}

std::vector<std::size_t> sharp_views(const std::vector<BoardView>& views) {
  constexpr double kLeast = 0.6;
  if (views.empty()) return {};
  std::vector<double> sorted;
  for (const BoardView& view : views) sorted.push_back(view.sharpness);
  std::sort(sorted.begin(), sorted.end());
  std::vector<std::size_t> sharp;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (views[i].sharpness >= kLeast * sorted[sorted.size() * 9 / 10]) sharp.push_back(i);
  }
  return sharp;
}

Result<CameraCalibration> calibrate_camera(const std::vector<BoardView>& views, const CalibrationTarget& target,
                                           PictureSize size) {
  CameraCalibration result;
  result.sharp = sharp_views(views);
  const std::size_t sharp = result.sharp.size();
  if (sharp < kFewestViews) {
    return too_little(
        fmt::format("{} views of the board, {} of them sharp; expected at least {} sharp ones from "
                    "different directions, better 30",
                    views.size(), sharp, kFewestViews));
  }
  result.blurred = views.size() - sharp;
  Estimate estimate = first_estimate(views, result.sharp, target, size);
  result.redundant = sharp - estimate.views.size();
  for (int round = 0; round < 2; ++round) {
    drop_outliers(estimate, result);
    if (estimate.views.size() < kFewestViews) {
      return too_little(
          fmt::format("only {} of {} sharp views agree on a lens, expected at least {}; check that "
                      "target.yaml is that of the board and that the board is flat",
                      estimate.views.size(), sharp, kFewestViews));
    }
    optimise(estimate.bundle, FreeLens::kWithoutK3);
  }
  const FreeLens free = finish(estimate.bundle);
  result.camera = model_of(estimate.bundle.lens, size.width, size.height);
  result.deviation = model_of(deviations_of(estimate.bundle, free), 0, 0);
  result.noise_px = std::sqrt(variance_of(estimate.bundle, free));
  result.covered = covered_by(estimate.bundle, size);
  describe(estimate, views, result);
  if (auto good = check(estimate.bundle, result, size); !good) return good.error();
  return result;
}

}  // namespace scanknit
