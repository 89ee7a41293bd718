#include "calibrate/depth/depth_fit.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "acquire/sensor/depth_bias.h"
#include "core/median.h"

namespace scanknit {
namespace {

// A wave of the field spans four cells or more. 12 by 9 cells show three waves across a picture and two down.
constexpr int kColumns = 15, kRows = 12;
constexpr int kNumbers = kColumns * kRows;
constexpr std::size_t kNumbersAtAPlace = 16;  // four by four B-splines are not 0 at a place
// Then: colour's delay, and a step of the pose between the cameras.
constexpr int kShift = 0, kScale = kNumbers, kDelay = 2 * kNumbers, kPose = kDelay + 1, kUnknowns = kPose + 6;

// What is assumed of the unknowns before anything is seen: standard deviations.
constexpr double kUsualShift_per_m = 0.02, kUsualScale = 0.03, kUsualDelay_s = 0.05;
constexpr double kUsualBaseline_m = 0.05, kUsualTurn_rad = 0.05;
constexpr double kUsualShiftBend_per_m = 0.003, kUsualScaleBend = 3e-5;  // of second differences

/// What one number of the unknowns counts in an equation.
struct Entry {
  int unknown = 0;
  double weight = 0;
};

/// That a sample lies on the board's plane. by_delay and by_pose are how 1 / z of the plane changes.
struct Equation {
  std::array<Entry, 2 * kNumbersAtAPlace> fields;  ///< of shift and scale: their sum is the correction of 1 / z
  double by_delay = 0;
  Eigen::Matrix<double, 1, 6> by_pose = Eigen::Matrix<double, 1, 6>::Zero();
  double left = 0;  ///< 1 / z of the plane less that of depth
};

/// The unknowns outside the fields, and the last solution.
struct State {
  Eigen::VectorXd numbers = Eigen::VectorXd::Zero(2 * kNumbers);
  double delay_s = 0;
  Pose correction = Pose::Identity();
  std::vector<PoseVector> off;  ///< how far each view's pose is from where colour shows it
};

/// A view's own pose, eliminated: step = solver.solve(right - mixed^T unknowns).
struct OwnPose {
  Eigen::LDLT<PoseMatrix> solver;
  Eigen::Matrix<double, Eigen::Dynamic, 6> mixed;
  PoseVector right;
};

struct System {
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(kUnknowns, kUnknowns);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(kUnknowns);
};

/// The entries of both fields at a place of the picture (0 to 1 each way), where depth is 1 / per_m.
std::array<Entry, 2 * kNumbersAtAPlace> field_entries(double across, double down, double per_m) {
  const SplineWeights x = spline_weights(across, kColumns), y = spline_weights(down, kRows);
  std::array<Entry, 2 * kNumbersAtAPlace> entries;
  for (std::size_t k = 0; k < kNumbersAtAPlace; ++k) {
    const std::size_t i = k % 4, j = k / 4;
    const int at = (y.first + static_cast<int>(j)) * kColumns + x.first + static_cast<int>(i);
    const double weight = y.weights[j] * x.weights[i];
    entries[2 * k] = {kShift + at, weight};
    entries[2 * k + 1] = {kScale + at, weight * per_m};
  }
  return entries;
}

std::array<Entry, 2 * kNumbersAtAPlace> field_entries(const Eigen::Vector2d& pixel, const CameraIntrinsics& camera,
                                                      double per_m) {
  return field_entries(spline_position(pixel.x(), camera.width), spline_position(pixel.y(), camera.height), per_m);
}

Equation equation_of(const DepthSample& sample, const DepthView& view, const Pose& T_depth_board, double delay_s,
                     const CameraIntrinsics& camera) {
  const Eigen::Vector3d normal = T_depth_board.linear().col(2);
  const double offset = normal.dot(T_depth_board.translation());
  const Eigen::Vector3d ray = camera.unproject(sample.pixel.x(), sample.pixel.y(), 1);
  const double plane_per_m = normal.dot(ray) / offset;
  Equation equation;
  equation.fields = field_entries(sample.pixel, camera, sample.per_m);
  equation.by_pose << -plane_per_m / offset * normal.transpose(), normal.cross(ray).transpose() / offset;
  if (view.motion) {
    equation.by_delay = equation.by_pose.dot((delay_s * view.motion->change - view.motion->speed).transpose());
  }
  equation.left = plane_per_m - sample.per_m;
  return equation;
}

/// Where the board is while depth is taken.
Pose pose_of(const DepthView& view, const State& state) {
  Pose pose = view.T_depth_board;
  const double t = -state.delay_s;
  if (view.motion) pose = moved(t * view.motion->speed + t * t / 2 * view.motion->change, pose);
  return state.correction * pose;
}

/// The correction of 1 / depth at a sample.
double corrected_by(const Equation& equation, const Eigen::VectorXd& numbers) {
  double sum = 0;
  for (const Entry& entry : equation.fields) sum += entry.weight * numbers[entry.unknown];
  return sum;
}

/// Adds to the equations that a field's second differences are small.
class Smoothness {
 public:
  explicit Smoothness(System& system) : system_(system) {}

  /// Every second difference of a field, along rows, columns and both.
  void add(int first, double deviation) {
    const double weight = 1 / (deviation * deviation);
    const auto at = [first](int x, int y) { return first + y * kColumns + x; };
    for (int y = 0; y < kRows; ++y) {
      for (int x = 0; x < kColumns; ++x) {
        if (x + 2 < kColumns) add({{at(x, y), 1}, {at(x + 1, y), -2}, {at(x + 2, y), 1}}, weight);
        if (y + 2 < kRows) add({{at(x, y), 1}, {at(x, y + 1), -2}, {at(x, y + 2), 1}}, weight);
        if (x + 1 == kColumns || y + 1 == kRows) continue;
        add({{at(x, y), 1}, {at(x + 1, y), -1}, {at(x, y + 1), -1}, {at(x + 1, y + 1), 1}}, 2 * weight);
      }
    }
  }

 private:
  using Terms = std::vector<std::pair<int, double>>;
  void add(const Terms& terms, double weight) {
    for (const auto& [i, a] : terms) {
      for (const auto& [j, b] : terms) system_.normal(i, j) += weight * a * b;
    }
  }
  System& system_;
};

System prior_of(const State& state, DepthToColour between) {
  System system;
  const auto usual = [&system](int at, double deviation, double now) {
    const double weight = 1 / (deviation * deviation);
    system.normal(at, at) += weight;
    system.right[at] -= weight * now;
  };
  for (int i = 0; i < kNumbers; ++i) {
    usual(kShift + i, kUsualShift_per_m, 0);
    usual(kScale + i, kUsualScale, 0);
  }
  usual(kDelay, kUsualDelay_s, state.delay_s);
  const bool is_free = between == DepthToColour::kEstimated;
  for (int i = 0; i < 6; ++i) {
    constexpr double kHeld = 1e-9;
    usual(kPose + i, is_free ? (i < 3 ? kUsualBaseline_m : kUsualTurn_rad) : kHeld, 0);
  }
  Smoothness smoothness(system);
  smoothness.add(kShift, kUsualShiftBend_per_m);
  smoothness.add(kScale, kUsualScaleBend);
  return system;
}

/// All entries: what moves the plane is on the other side.
std::vector<Entry> entries_of(const Equation& equation) {
  std::vector<Entry> entries(equation.fields.begin(), equation.fields.end());
  entries.push_back({kDelay, -equation.by_delay});
  for (int i = 0; i < 6; ++i) entries.push_back({kPose + i, -equation.by_pose[i]});
  return entries;
}

/// What the samples of one view say, its own pose eliminated.
OwnPose add_view(const DepthView& view, const PoseVector& off_before, const State& state,
                 const CameraIntrinsics& camera, double noise_per_m, System& system) {
  constexpr double kHuber = 3;  // deviations
  PoseMatrix own = view.information;
  PoseVector own_right = PoseVector::Zero();
  Eigen::Matrix<double, Eigen::Dynamic, 6> mixed = Eigen::Matrix<double, Eigen::Dynamic, 6>::Zero(kUnknowns, 6);
  const Pose T_depth_board = pose_of(view, state);
  for (const DepthSample& sample : view.samples) {
    Equation equation = equation_of(sample, view, T_depth_board, state.delay_s, camera);
    const double residual = equation.left - corrected_by(equation, state.numbers) + equation.by_pose.dot(off_before);
    // Depth's noise stays on one side: where it also weighs the scale, it pulls it (errors in variables, Fuller 1987).
    equation.fields = field_entries(sample.pixel, camera, sample.per_m + residual);
    const double weight =
        std::min(1.0, kHuber / std::max(std::abs(residual) / noise_per_m, 1e-12)) / (noise_per_m * noise_per_m);
    const auto entries = entries_of(equation);
    for (const auto& [i, a] : entries) {
      for (const auto& [j, b] : entries) system.normal(i, j) += weight * a * b;
      system.right[i] += weight * a * equation.left;
      mixed.row(i) -= weight * a * equation.by_pose;
    }
    own += weight * equation.by_pose.transpose() * equation.by_pose;
    own_right -= weight * equation.by_pose.transpose() * equation.left;
  }
  const Eigen::LDLT<PoseMatrix> solver(own);
  system.normal.noalias() -= mixed * solver.solve(mixed.transpose());
  system.right -= mixed * solver.solve(own_right);
  return {solver, std::move(mixed), own_right};
}

/// The deviation of samples from their view's own plane, whatever its pose.
double noise_of(const std::vector<DepthView>& views) {
  std::vector<double> off;
  for (const DepthView& view : views) {
    const auto count = static_cast<Eigen::Index>(view.samples.size());
    if (count < 6) continue;
    Eigen::MatrixX3d rows(count, 3);
    Eigen::VectorXd per_m(count);
    for (Eigen::Index i = 0; i < count; ++i) {
      const DepthSample& sample = view.samples[static_cast<std::size_t>(i)];
      rows.row(i) << sample.pixel.x(), sample.pixel.y(), 1;
      per_m[i] = sample.per_m;
    }
    const Eigen::Vector3d plane = (rows.transpose() * rows).ldlt().solve(rows.transpose() * per_m);
    for (const double value : Eigen::VectorXd(per_m - rows * plane)) off.push_back(std::abs(value));
  }
  constexpr double kMedianInDeviations = 0.6745;  // of the absolute values of normal numbers
  constexpr double kLeast_per_m = 1e-6;
  return std::max(median(std::move(off)) / kMedianInDeviations, kLeast_per_m);
}

/// How much farther the views' poses are from where colour shows them than their information says, as a factor of the
/// variance: at least 1. A rolling shutter, blur or a board that bends makes it so. A plane tells three of the six
/// numbers of a pose.
double excess_of(const std::vector<DepthView>& views, const std::vector<PoseVector>& off) {
  constexpr double kToldByAPlane = 3;
  std::vector<double> squares;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!views[i].samples.empty()) squares.push_back(off[i].dot(views[i].information * off[i]) / kToldByAPlane);
  }
  double sum = 0;
  for (const double square : squares) sum += square;
  return std::max(1.0, sum / static_cast<double>(std::max<std::size_t>(1, squares.size())));
}

DepthBias bias_of(const Eigen::VectorXd& numbers) {
  DepthBias bias{kColumns, kRows, {}, {}};
  for (int i = 0; i < kNumbers; ++i) {
    bias.scale.push_back(std::clamp(numbers[kScale + i], -DepthBias::kMostScale, DepthBias::kMostScale));
    bias.shift_per_m.push_back(
        std::clamp(numbers[kShift + i], -DepthBias::kMostShift_per_m, DepthBias::kMostShift_per_m));
  }
  return bias;
}

/// The mean deviation over the picture at each distance.
std::array<DepthDeviation, 3> deviations_of(const Eigen::MatrixXd& covariance) {
  constexpr std::size_t kPlaces = 7;  // each way
  const auto middle = [](std::size_t place) { return (static_cast<double>(place) + 0.5) / kPlaces; };
  std::array<DepthDeviation, 3> result{{{1, 0}, {2, 0}, {4, 0}}};
  for (DepthDeviation& at : result) {
    for (std::size_t place = 0; place < kPlaces * kPlaces; ++place) {
      Eigen::VectorXd row = Eigen::VectorXd::Zero(kUnknowns);
      const auto entries = field_entries(middle(place % kPlaces), middle(place / kPlaces), 1 / at.distance_m);
      for (const Entry& entry : entries) row[entry.unknown] = entry.weight;
      const double per_m = std::sqrt(std::max(0.0, row.dot(covariance * row)));
      at.deviation_m += at.distance_m * at.distance_m * per_m / (kPlaces * kPlaces);
    }
  }
  return result;
}

void describe_samples(const std::vector<DepthView>& views, const State& state, const CameraIntrinsics& camera,
                      DepthCalibration& result) {
  std::vector<double> depths, before, after;
  for (const DepthView& view : views) {
    result.views += view.samples.empty() ? 0 : 1;
    for (const DepthSample& sample : view.samples) {
      const double z = 1 / sample.per_m;
      const Equation given = equation_of(sample, view, view.T_depth_board, 0, camera);
      const Equation found = equation_of(sample, view, pose_of(view, state), state.delay_s, camera);
      depths.push_back(z);
      before.push_back(z * z * std::abs(given.left));
      after.push_back(z * z * std::abs(found.left - corrected_by(found, state.numbers)));
    }
  }
  result.samples = depths.size();
  result.nearest_m = percentile(depths, 0.05);
  result.farthest_m = percentile(depths, 0.95);
  result.before_m = median(std::move(before));
  result.after_m = median(std::move(after));
}

/// The step from one pose to another.
PoseVector step_between(const Pose& from, const Pose& to) {
  const Pose motion = to * from.inverse();
  const Eigen::AngleAxisd turn(motion.linear());
  PoseVector step;
  step << motion.translation(), turn.angle() * turn.axis();
  return step;
}

}  // namespace

BoardMotion motion_through(const Pose& before, const Pose& now, const Pose& after, double before_s, double after_s) {
  const PoseVector earlier = -step_between(now, before) / before_s;
  const PoseVector later = step_between(now, after) / after_s;
  const double span_s = before_s + after_s;
  return {(after_s * earlier + before_s * later) / span_s, 2 * (later - earlier) / span_s};
}

Result<DepthCalibration> fit_depth(const std::vector<DepthView>& views, const CameraIntrinsics& camera,
                                   DepthToColour between) {
  const auto seen =
      std::count_if(views.begin(), views.end(), [](const DepthView& view) { return !view.samples.empty(); });
  if (static_cast<std::size_t>(seen) < kFewestDepthViews) {
    return Error{ErrorCode::kTooLittle,
                 fmt::format("depth shows the board in {} pictures, expected at least {}", seen, kFewestDepthViews)};
  }
  const double noise_per_m = noise_of(views);
  State state;
  state.off.assign(views.size(), PoseVector::Zero());
  Eigen::MatrixXd covariance;
  constexpr int kRounds = 5;
  for (int round = 0; round < kRounds; ++round) {
    System system = prior_of(state, between);
    std::vector<OwnPose> own;
    for (std::size_t i = 0; i < views.size(); ++i) {
      own.push_back(add_view(views[i], state.off[i], state, camera, noise_per_m, system));
    }
    const Eigen::LDLT<Eigen::MatrixXd> solver(system.normal);
    const Eigen::VectorXd solved = solver.solve(system.right);
    if (!solved.allFinite()) return Error{ErrorCode::kTooLittle, "the depth of the board is not that of a plane"};
    for (std::size_t i = 0; i < views.size(); ++i) {
      state.off[i] = own[i].solver.solve(own[i].right - own[i].mixed.transpose() * solved);
    }
    state.numbers = solved.head(2 * kNumbers);
    state.delay_s += solved[kDelay];
    state.correction = moved(solved.tail<6>(), state.correction);
    if (round + 1 < kRounds) continue;
    covariance = excess_of(views, state.off) * solver.solve(Eigen::MatrixXd::Identity(kUnknowns, kUnknowns));
  }
  DepthCalibration result;
  result.bias = bias_of(state.numbers);
  result.colour_later_s = state.delay_s;
  constexpr double kMotionError = 0.03;  // of the board's speed, which is found from three pictures
  result.colour_later_deviation_s = std::hypot(std::sqrt(covariance(kDelay, kDelay)), kMotionError * state.delay_s);
  result.correction = state.correction;
  result.correction_deviation = covariance.diagonal().tail<6>().cwiseMax(0.0).cwiseSqrt();
  result.deviations = deviations_of(covariance);
  describe_samples(views, state, camera, result);
  return result;
}

}  // namespace scanknit
