// The lens from corners with injected noise, against the truth and against OpenCV's calibrateCamera.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <random>

#include "acquire/replay/undistort.h"
#include "calibrate/calibrate_camera.h"
#include "calibrate/lens/bundle.h"
#include "core/rotation.h"

namespace scanknit {
namespace {

constexpr CalibrationTarget kTarget{TargetType::kAprilGrid, 6, 4, 0.04};
constexpr PictureSize kSize{640, 480};
constexpr int kSeeds = 10;

const CameraModel kTruth{{640, 480, 531.2, 529.8, 322.7, 236.1}, {0.08, -0.21, 0.0011, -0.0007, 0}};

/// How the board is held: up to `tilt_degrees` aside and 0.4 to 0.8 m away, anywhere in the picture.
BoardView view_of(std::mt19937_64& random, double noise_px, double tilt_degrees, const CameraModel& camera) {
  std::uniform_real_distribution<double> evenly(-1, 1);
  std::normal_distribution<double> noise(0, noise_px);
  const Eigen::Matrix3d R = (Eigen::AngleAxisd(tilt_degrees * kDegree * evenly(random), Eigen::Vector3d::UnitX()) *
                             Eigen::AngleAxisd(tilt_degrees * kDegree * evenly(random), Eigen::Vector3d::UnitY()) *
                             Eigen::AngleAxisd(30 * kDegree * evenly(random), Eigen::Vector3d::UnitZ()))
                                .toRotationMatrix();
  const Eigen::Vector3d middle(0.2 * evenly(random), 0.15 * evenly(random), 0.6 + 0.2 * evenly(random));
  BoardView view{.picture = "", .corners = {}, .sharpness = 0.4};
  const auto corners = target_corners(kTarget);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2d on_board = corners[i] - extent_m(kTarget) / 2;
    const Eigen::Vector3d p = R * Eigen::Vector3d(on_board.x(), on_board.y(), 0) + middle;
    const Eigen::Vector2d ideal = camera.intrinsics.project(p);
    const Eigen::Vector2d pixel = distort_pixel(ideal.x(), ideal.y(), camera.intrinsics, camera.distortion) +
                                  Eigen::Vector2d(noise(random), noise(random));
    const bool is_inside = pixel.x() > 0 && pixel.y() > 0 && pixel.x() < 639 && pixel.y() < 479;
    if (is_inside) view.corners.push_back({static_cast<int>(i), pixel});
  }
  return view;
}

std::vector<BoardView> views_of(int seed, double noise_px, std::size_t count = 40, double tilt_degrees = 40) {
  std::mt19937_64 random(static_cast<std::uint64_t>(seed));
  std::vector<BoardView> views;
  while (views.size() < count) {
    BoardView view = view_of(random, noise_px, tilt_degrees, kTruth);
    view.picture = "view " + std::to_string(views.size());
    if (view.corners.size() >= kFewestCorners) views.push_back(std::move(view));
  }
  return views;
}

std::array<double, 9> numbers_of(const CameraModel& model) {
  const auto& [k, d] = model;
  return {k.fx, k.fy, k.cx, k.cy, d[0], d[1], d[2], d[3], d[4]};
}

/// fx fy cx cy k1 k2 p1 p2 k3, by OpenCV from the same corners.
std::array<double, 9> numbers_by_opencv(const std::vector<BoardView>& views) {
  const auto corners = target_corners(kTarget);
  std::vector<std::vector<cv::Point3f>> points;
  std::vector<std::vector<cv::Point2f>> pixels;
  for (const BoardView& view : views) {
    points.emplace_back(), pixels.emplace_back();
    for (const SeenCorner& corner : view.corners) {
      const Eigen::Vector2d& p = corners[static_cast<std::size_t>(corner.number)];
      points.back().emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()), 0.0f);
      pixels.back().emplace_back(static_cast<float>(corner.pixel.x()), static_cast<float>(corner.pixel.y()));
    }
  }
  cv::Mat K, d;
  std::vector<cv::Mat> turns, shifts;
  cv::calibrateCamera(points, pixels, {kSize.width, kSize.height}, K, d, turns, shifts, cv::CALIB_FIX_K3,
                      {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 60, 1e-12});
  return {K.at<double>(0, 0), K.at<double>(1, 1), K.at<double>(0, 2),
          K.at<double>(1, 2), d.at<double>(0),    d.at<double>(1),
          d.at<double>(2),    d.at<double>(3),    0};
}

TEST(CalibrateCamera, FindsTheLensWithinItsOwnDeviations) {
  constexpr double kNoise_px = 0.1;  // of corners in good pictures
  int beyond_three = 0, numbers = 0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const auto found = calibrate_camera(views_of(seed, kNoise_px, 60), kTarget, kSize);
    ASSERT_TRUE(found) << found.error().text();
    const CameraIntrinsics& k = found->camera.intrinsics;
    EXPECT_NEAR(k.fx, kTruth.intrinsics.fx, 0.001 * kTruth.intrinsics.fx) << seed;
    EXPECT_NEAR(k.fy, kTruth.intrinsics.fy, 0.001 * kTruth.intrinsics.fy) << seed;
    EXPECT_NEAR(k.cx, kTruth.intrinsics.cx, 0.5) << seed;
    EXPECT_NEAR(k.cy, kTruth.intrinsics.cy, 0.5) << seed;
    EXPECT_NEAR(found->noise_px, kNoise_px, 0.1 * kNoise_px) << seed;
    EXPECT_NEAR(found->error_px, kNoise_px * std::numbers::sqrt2, 0.1 * kNoise_px * std::numbers::sqrt2) << seed;
    EXPECT_EQ(found->outlying, 0u) << seed;
    const auto estimate = numbers_of(found->camera);
    const auto truth = numbers_of(kTruth);
    const auto deviation = numbers_of(found->deviation);
    for (std::size_t i = 0; i < estimate.size(); ++i) {
      if (deviation[i] == 0) continue;  // k3, where it was not estimated
      ++numbers;
      beyond_three += std::abs(estimate[i] - truth[i]) > 3 * deviation[i] ? 1 : 0;
    }
  }
  EXPECT_GE(numbers, kSeeds * 8);
  EXPECT_LE(beyond_three, numbers / 100 + 1) << "of " << numbers;  // 0.27 % of normal numbers are
}

TEST(CalibrateCamera, IsNoWorseThanOpenCv) {
  double ours = 0, theirs = 0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const auto views = views_of(seed, 0.2, 16);
    const auto found = calibrate_camera(views, kTarget, kSize);
    ASSERT_TRUE(found) << found.error().text();
    const auto a = numbers_of(found->camera), b = numbers_by_opencv(views), truth = numbers_of(kTruth);
    const auto deviation = numbers_of(found->deviation);
    for (std::size_t i = 0; i < 8; ++i) {  // in deviations: one scale for all numbers
      ours += std::pow((a[i] - truth[i]) / deviation[i], 2);
      theirs += std::pow((b[i] - truth[i]) / deviation[i], 2);
    }
  }
  RecordProperty("ours", std::to_string(std::sqrt(ours / (8 * kSeeds))));
  RecordProperty("opencv", std::to_string(std::sqrt(theirs / (8 * kSeeds))));
  EXPECT_LE(ours, 1.02 * theirs);
}

TEST(CalibrateCamera, IsExactWithoutNoise) {
  const auto found = calibrate_camera(views_of(1, 0), kTarget, kSize);
  ASSERT_TRUE(found) << found.error().text();
  const auto estimate = numbers_of(found->camera), truth = numbers_of(kTruth);
  for (std::size_t i = 0; i < 8; ++i) EXPECT_NEAR(estimate[i], truth[i], 1e-4 * std::max(1.0, std::abs(truth[i]))) << i;
  EXPECT_LT(found->error_px, 1e-4);
}

TEST(CalibrateCamera, LeavesOutWrongCornersAndViews) {
  auto views = views_of(3, 0.2);
  for (std::size_t i = 0; i < 10; ++i) views[i].corners[5].pixel.x() += 6;
  for (SeenCorner& corner : views[20].corners) corner.pixel.x() += 4 * std::sin(corner.pixel.y() / 20);
  const auto found = calibrate_camera(views, kTarget, kSize);
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_EQ(found->outlying, 1u);
  EXPECT_GE(found->outlying_corners, 10u);
  EXPECT_NEAR(found->noise_px, 0.2, 0.02);
  EXPECT_TRUE(std::none_of(found->views.begin(), found->views.end(),
                           [](const UsedView& view) { return view.picture == "view 20"; }));
}

TEST(CalibrateCamera, LeavesOutBlurredViews) {
  auto views = views_of(4, 0.2);
  for (std::size_t i = 0; i < 15; ++i) views[i].sharpness = 0.15;
  const auto found = calibrate_camera(views, kTarget, kSize);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->blurred, 15u);
  EXPECT_EQ(found->views.size(), 25u);
}

TEST(CalibrateCamera, OfManyViewsTakesThoseThatTellMost) {
  auto views = views_of(5, 0.2, 200, 2);  // hardly tilted
  const auto tilted = views_of(6, 0.2, 30, 40);
  for (const BoardView& view : tilted) views.push_back({"tilted", view.corners, view.sharpness});
  const auto found = calibrate_camera(views, kTarget, kSize);
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_EQ(found->views.size(), 60u);
  EXPECT_EQ(found->redundant, 170u);
  EXPECT_GE(std::count_if(found->views.begin(), found->views.end(),
                          [](const UsedView& view) { return view.picture == "tilted"; }),
            20);
}

TEST(CalibrateCamera, RefusesTooFewViews) {
  for (const std::size_t count : {std::size_t{0}, std::size_t{1}, kFewestViews - 1}) {
    const auto found = calibrate_camera(views_of(1, 0.2, count), kTarget, kSize);
    ASSERT_FALSE(found) << count;
    EXPECT_EQ(found.error().code, ErrorCode::kTooLittle);
  }
}

TEST(CalibrateCamera, RefusesViewsThatAreAlike) {
  for (const double tilt_degrees : {0.0, 3.0}) {
    const auto found = calibrate_camera(views_of(1, 0.2, 40, tilt_degrees), kTarget, kSize);
    ASSERT_FALSE(found) << tilt_degrees;
    EXPECT_EQ(found.error().code, ErrorCode::kTooLittle);
    EXPECT_NE(found.error().message.find("too alike"), std::string::npos) << found.error().message;
  }
}

TEST(LensProjection, HasTheDerivativesThatItSays) {
  const LensVector lens = lens_of(kTruth);
  const Eigen::Vector3d p(0.13, -0.08, 0.5);
  const Projection at = project(lens, p);
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 9; ++i) {
    const LensVector step = kStep * LensVector::Unit(i);
    const Eigen::Vector2d slope = (project(lens + step, p).pixel - project(lens - step, p).pixel) / (2 * kStep);
    EXPECT_LT((slope - at.by_lens.col(i)).norm(), 1e-6 * std::max(1.0, slope.norm())) << i;
  }
  for (int i = 0; i < 6; ++i) {
    const Eigen::Vector3d unit = Eigen::Vector3d::Unit(i % 3);
    const Eigen::Vector3d step = kStep * (i < 3 ? unit : Eigen::Vector3d(unit.cross(p)));
    const Eigen::Vector2d slope = (project(lens, p + step).pixel - project(lens, p - step).pixel) / (2 * kStep);
    EXPECT_LT((slope - at.by_pose.col(i)).norm(), 1e-5 * std::max(1.0, slope.norm())) << i;
  }
}

}  // namespace
}  // namespace scanknit
