// The error of depth, the time and the pose between depth and colour, from views of a board with injected faults.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <array>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "acquire/sensor/depth_bias.h"
#include "calibrate/depth/depth_fit.h"
#include "calibrate/lens/lens.h"
#include "calibrate/target/calibration_target.h"
#include "core/rotation.h"

namespace scanknit {
namespace {

constexpr CalibrationTarget kTarget{TargetType::kAprilGrid, 6, 4, 0.04};
constexpr int kSeeds = 10;
constexpr int kViews = 150;
constexpr double kRate_hz = 30, kLater_s = 0.012;
constexpr int kEvery = 4;  // pictures of which one is looked at
constexpr double kCornerNoise_px = 0.1, kDepthNoise_per_m = 0.0005;

const CameraIntrinsics kCamera{640, 480, 531.2, 529.8, 322.7, 236.1};

/// 1.5 % at 4 m, in waves over the picture whose place is another for each seed.
double shift_at(double across, double down, int seed) {
  return 0.00375 * std::sin(kFullTurn * (1.4 * across + 0.13 * seed)) *
         std::cos(kFullTurn * (1.1 * down + 0.07 * seed));
}
constexpr double kScale = 0.004;

/// The board before the depth camera: swung, and moved to all parts of the picture, 0.45 to 1.05 m away.
Pose board_at(double t) {
  const double s = kFullTurn * t * kRate_hz / (kViews * kEvery);
  Pose pose = Pose::Identity();
  pose.linear() = (Eigen::AngleAxisd(35 * kDegree * std::sin(3 * s), Eigen::Vector3d::UnitX()) *
                   Eigen::AngleAxisd(40 * kDegree * std::sin(2 * s + 1), Eigen::Vector3d::UnitY()) *
                   Eigen::AngleAxisd(30 * kDegree * std::sin(s), Eigen::Vector3d::UnitZ()))
                      .toRotationMatrix();
  const double z = 0.75 + 0.3 * std::cos(4 * s);
  const Eigen::Vector2d middle = extent_m(kTarget) / 2;
  pose.translation() = Eigen::Vector3d(0.45 * z * std::sin(5 * s), 0.3 * z * std::cos(7 * s), z) -
                       pose.linear() * Eigen::Vector3d(middle.x(), middle.y(), 0);
  return pose;
}

PoseMatrix information_at(const Pose& pose) {
  BundleView view;
  view.T_camera_board = pose;
  view.board_m = target_corners(kTarget);
  view.pixels.resize(view.board_m.size());
  return pose_information(lens_of({kCamera, {}}), view) / (kCornerNoise_px * kCornerNoise_px);
}

class Simulation {
 public:
  /// `T_false_true`: by how much the pose between the cameras is stated wrongly.
  explicit Simulation(int seed, const Pose& T_false_true = Pose::Identity())
      : seed_(seed), random_(static_cast<std::uint64_t>(seed)) {
    for (int i = 0; i < kViews; ++i) views_.push_back(view_at(i * kEvery / kRate_hz, T_false_true));
  }
  [[nodiscard]] const std::vector<DepthView>& views() const { return views_; }

 private:
  DepthView view_at(double t, const Pose& T_false_true) {
    const Pose seen_by_colour = board_at(t + kLater_s);
    DepthView view;
    view.information = information_at(seen_by_colour);
    PoseVector step;
    for (double& value : step) value = normal_(random_);
    step = Eigen::LLT<PoseMatrix>(view.information).matrixU().solve(step).eval();
    view.T_depth_board = moved(step, T_false_true * seen_by_colour);
    constexpr double kPeriod_s = 1 / kRate_hz;
    view.motion = motion_through(board_at(t + kLater_s - kPeriod_s), seen_by_colour, board_at(t + kLater_s + kPeriod_s),
                                 kPeriod_s, kPeriod_s);
    const Pose now = board_at(t);
    const Eigen::Vector3d n = now.linear().col(2);
    for (int y = 4; y < kCamera.height; y += 16) {
      for (int x = 4; x < kCamera.width; x += 16) {
        const Eigen::Vector3d ray = kCamera.unproject(x, y, 1);
        const double z = n.dot(now.translation()) / n.dot(ray);
        const Eigen::Vector3d on_board = now.inverse() * (z * ray);
        const Eigen::Vector2d extent = extent_m(kTarget);
        if (on_board.x() < 0 || on_board.y() < 0 || on_board.x() > extent.x() || on_board.y() > extent.y()) continue;
        const double shift = shift_at(spline_position(x, kCamera.width), spline_position(y, kCamera.height), seed_);
        const double per_m = (1 / z - shift) / (1 + kScale);
        view.samples.push_back({Eigen::Vector2d(x, y), per_m + kDepthNoise_per_m * normal_(random_)});
      }
    }
    return view;
  }

  int seed_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_{0, 1};
  std::vector<DepthView> views_;
};

/// What is left of the injected error over the picture at one distance, as a share: root mean squares.
double left_at(double z, const DepthBias& bias, int seed) {
  DepthImage measured(64, 48);
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) {
      const double shift = shift_at(spline_position(x, 64), spline_position(y, 48), seed);
      measured.at(x, y) = static_cast<float>((1 + kScale) / (1 / z - shift));
    }
  }
  DepthImage corrected = measured;
  DepthCorrection(bias, 64, 48).apply(corrected);
  double before = 0, after = 0;
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) {
      before += std::pow(static_cast<double>(measured.at(x, y)) - z, 2);
      after += std::pow(static_cast<double>(corrected.at(x, y)) - z, 2);
    }
  }
  return std::sqrt(after / before);
}

TEST(FitDepth, LeavesLittleOfTheErrorAndFindsTheDelay) {
  int beyond_three = 0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const auto found = fit_depth(Simulation(seed).views(), kCamera, DepthToColour::kKnown);
    ASSERT_TRUE(found) << found.error().text();
    ASSERT_TRUE(is_valid(found->bias));
    for (const double z : {0.5, 1.0, 2.0, 4.0}) {
      const double left = left_at(z, found->bias, seed);
      RecordProperty("left_" + std::to_string(seed) + "_" + std::to_string(z).substr(0, 3), std::to_string(left));
      EXPECT_LT(left, 0.15) << "at " << z << " m, seed " << seed;
    }
    EXPECT_NEAR(found->colour_later_s, kLater_s, 0.001) << seed;
    EXPECT_LT(found->colour_later_deviation_s, 0.001) << seed;
    beyond_three += std::abs(found->colour_later_s - kLater_s) > 3 * found->colour_later_deviation_s ? 1 : 0;
    EXPECT_TRUE(found->correction.isApprox(Pose::Identity(), 1e-6)) << "it is known";
    EXPECT_LT(found->after_m, found->before_m / 2);
  }
  EXPECT_EQ(beyond_three, 0);
}

TEST(FitDepth, FindsThePoseBetweenTheCameras) {
  PoseVector off;
  off << 0.006, -0.004, 0.003, 0.008, -0.006, 0.01;
  const Pose T_false_true = moved(off, Pose::Identity());
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const auto found = fit_depth(Simulation(seed, T_false_true).views(), kCamera, DepthToColour::kEstimated);
    ASSERT_TRUE(found) << found.error().text();
    const Pose left = found->correction * T_false_true;
    EXPECT_LT(left.translation().norm(), 0.0005) << seed;
    EXPECT_LT(Eigen::AngleAxisd(left.linear()).angle(), 0.05 * kDegree) << seed;
    EXPECT_LT(left.translation().norm(), 4 * found->correction_deviation.head<3>().norm()) << seed;
  }
}

TEST(FitDepth, RefusesTooFewViews) {
  auto views = Simulation(1).views();
  views.resize(kFewestDepthViews - 1);
  const auto found = fit_depth(views, kCamera, DepthToColour::kKnown);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, ErrorCode::kTooLittle);
  EXPECT_NE(found.error().text().find("7 pictures, expected at least 8"), std::string::npos) << found.error().text();
}

}  // namespace
}  // namespace scanknit
