#include "fusion/register/icp.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "fusion/register/contradiction.h"
#include "fusion/register/icp_rows.h"
#include "fusion/register/scene_change.h"

namespace scanknit {
namespace {

// A direction held by less than this share of the points is moved by noise. A wall's normals wander by two degrees
// where it is seen in few noisy frames: the square of that.
constexpr double kWeakStrength = 1e-3;
constexpr double kInlierSigmas = 3;
constexpr double kFewestPairs = 50;

/// What one level does: `iterations` rounds, with gates that narrow from the first to the last.
struct LevelPlan {
  int iterations;
  double distance_m, distance_per_m;
  double first_tukey, last_tukey;  ///< sigmas
  double min_cosine;
  double intensity_share;  ///< of IcpConfig::intensity_sigma: coarse pictures differ less
  int times_colour_from;   ///< the round with which the search for the time of colour begins: near the pose
  double alike;            ///< errors of depth are alike over so many pixels; those of intensity are not
};

// The coarse level begins wide: 3 degrees and 5 cm between frames are 30 sigma at arm's length. Sensors match windows
// of 7 to 13 pixels of 640 (docs/synthetic_scanner.md): 4 x 4 of the finest level.
constexpr std::array<LevelPlan, kPyramidLevels> kPlans{{
    {4, 0.02, 0.02, 6, 5, 0.7, 1.0, 0, 16},
    {6, 0.05, 0.03, 12, 6, 0.6, 1.0, 0, 4},
    {12, 0.10, 0.06, 40, 12, 0.5, 1.0, 6, 1},
}};

PairGate gate_of(const LevelPlan& plan, int iteration, const IcpConfig& config, double intensity_offset) {
  const double progress =
      plan.iterations <= 1 ? 1.0 : static_cast<double>(iteration) / static_cast<double>(plan.iterations - 1);
  PairGate gate;
  gate.distance_m = static_cast<float>(plan.distance_m);
  gate.distance_per_m = static_cast<float>(plan.distance_per_m);
  gate.min_cosine = static_cast<float>(plan.min_cosine);
  gate.tukey_sigmas = static_cast<float>(plan.first_tukey * std::pow(plan.last_tukey / plan.first_tukey, progress));
  gate.contradiction_m = static_cast<float>(kContradiction_m);
  gate.contradiction_sigmas = static_cast<float>(kContradictionSigmas);
  gate.inlier_sigmas = static_cast<float>(kInlierSigmas);
  gate.intensity_sigma = static_cast<float>(config.intensity_sigma * plan.intensity_share);
  gate.intensity_offset = static_cast<float>(intensity_offset);
  return gate;
}

/// Row by row, in the rows' order.
PairSums sum_pairs(const Registration& registration) {
  std::vector<PairSums> rows(static_cast<std::size_t>(registration.frame->intrinsics.height));
  constexpr std::size_t kRowsAtATime = 8;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, rows.size(), kRowsAtATime), [&](const auto& range) {
    for (std::size_t y = range.begin(); y != range.end(); ++y) rows[y] = sum_row(registration, static_cast<int>(y));
  });
  PairSums sums;
  for (const PairSums& row : rows) sums += row;
  return sums;
}

Matrix6d information_of(const PairSums& sums) {
  Matrix6d JtJ;
  std::size_t entry = 0;
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) JtJ(row, column) = JtJ(column, row) = sums.JtJ[entry++];
  }
  return JtJ;
}

/// What is known of the time of colour without looking at the picture, in the units of the sums.
struct TimePrior {
  double information = 0, gradient = 0;
};

/// One Gauss-Newton step, and what it says of the scene.
struct Step {
  Vector6d motion = Vector6d::Zero();  ///< translation (m), rotation times scale
  double colour_later = 0;             ///< by which Registration::colour_later changes
  Vector6d strengths = Vector6d::Zero();
  Matrix6d information = Matrix6d::Zero();  ///< of the directions that are not weak
  int weak_directions = 6;
};

/// The time of colour is eliminated (Schur complement): what it explains holds no pose.
Step solve(const PairSums& sums, const TimePrior& prior) {
  Step step;
  if (sums.weights < kFewestPairs || !(sums.information > 0)) return step;
  Matrix6d JtJ = information_of(sums);
  Vector6d downhill = -Eigen::Map<const Vector6d>(sums.Jtr.data());
  const Eigen::Map<const Vector6d> JtD(sums.JtD.data());
  const double DtD = sums.DtD + prior.information;
  const double Dtr = sums.Dtr + prior.gradient;
  if (DtD > 0) {
    JtJ -= JtD * JtD.transpose() / DtD;
    downhill += JtD * (Dtr / DtD);
  }
  const SymmetricModes modes = modes_of(JtJ);
  step.strengths = modes.values / sums.information;
  step.weak_directions = 0;
  for (int i = 0; i < 6; ++i) {
    if (!(step.strengths(i) > kWeakStrength)) {
      ++step.weak_directions;
      continue;
    }
    const Vector6d direction = modes.vectors.col(i);
    step.motion += direction * (direction.dot(downhill) / modes.values(i));
    step.information += modes.values(i) * direction * direction.transpose();
  }
  if (DtD > 0) step.colour_later = -(Dtr + JtD.dot(step.motion)) / DtD;
  return step;
}

/// p' = R (p - centre) + centre + translation
Pose motion_about(const Vector6d& motion, const Eigen::Vector3d& centre, double scale_m) {
  const Eigen::Vector3d turn = motion.tail<3>() / scale_m;
  const double angle = turn.norm();
  Pose pose = Pose::Identity();
  if (angle > 0) pose.linear() = Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
  pose.translation() = centre + motion.head<3>() - pose.linear() * centre;
  return pose;
}

/// The mean depth of a level; 1 without a surface.
double mean_depth(const SurfaceLevel& level) {
  double sum = 0;
  std::size_t count = 0;
  for (const float z : level.z_m) {
    if (!(z > 0)) continue;
    sum += static_cast<double>(z);
    ++count;
  }
  return count > 0 ? sum / static_cast<double>(count) : 1.0;
}

/// The unit of rotation: the mean depth, but for a small object far away, whose points a turn moves by far less than
/// that: some times its extent.
double turning_scale(const SurfaceLevel& level, double depth_m) {
  constexpr double kTimes = 4;  // of the points' deviation: more than the depth where the picture is full
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double squares = 0;
  double count = 0;
  const CameraIntrinsics& camera = level.intrinsics;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const double z = static_cast<double>(level.z_m[level.index(x, y)]);
      if (!(z > 0)) continue;
      const Eigen::Vector3d p = camera.unproject(x, y, z);
      sum += p;
      squares += p.squaredNorm();
      ++count;
    }
  }
  if (count == 0) return depth_m;
  const double variance = std::max(0.0, squares / count - (sum / count).squaredNorm());
  constexpr double kLeast_m = 0.01;  // a point is no object
  return std::min(depth_m, std::max(kLeast_m, kTimes * std::sqrt(variance)));
}

void describe(const PairSums& sums, const Step& step, IcpResult& result) {
  const auto share = [](double part, double whole) { return whole > 0 ? part / whole : 0; };
  result.points = static_cast<std::size_t>(sums.points);
  result.overlap = share(sums.seen, sums.points);
  result.inlier_share = share(sums.inliers, sums.seen);
  result.contradicted_share = share(sums.contradictions, sums.seen);
  result.rms_sigma = std::sqrt(share(sums.squares, sums.weights));
  result.colour_agreement = sums.coloured > kFewestPairs ? sums.colour_weights / sums.coloured : 1;
  result.support = share(sums.weights + sums.colour_weights, sums.points);
  result.strengths = step.strengths;
  result.weak_directions = step.weak_directions;
}

// Less than this is not seen in a picture.
constexpr double kLeast_px = 0.25;

/// How the frame's camera moves while it takes rows and colour.
void take_motion(const MovingCamera& moving, bool times_colour, Registration& registration) {
  const SteadyMotion motion = moving.motion(registration.T_model_frame);
  registration.rows = motion * moving.readout;
  // Colour that cannot be off by so much is compared where it was read; and so is that of frames far apart, between
  // which no hand has moved the camera steadily. In the time that is uncertain, 10 ms, a hand turns it by 2 degrees.
  constexpr double kMost_rad = 0.04;
  constexpr double kMost_m = 0.02;
  const SteadyMotion uncertain = motion * moving.colour_sigma;
  const bool matters = times_colour &&
                       uncertain.pixels(registration.frame->intrinsics, registration.centre.z()) > kLeast_px &&
                       uncertain.turn_rad.norm() < kMost_rad && uncertain.shift_m.norm() < kMost_m;
  registration.colour_motion = matters ? motion : SteadyMotion{};
}

/// Whether colour shows what depth shows at the same time, or registration looks for its time.
bool is_colour_timely(const IcpConfig& config, const Registration& registration) {
  if (!config.moving || config.moving->colour_sigma == 0) return config.colour_is_timely;
  if (!registration.colour_motion.is_still()) return true;
  const SteadyMotion uncertain = config.moving->motion(registration.T_model_frame) * config.moving->colour_sigma;
  return uncertain.pixels(registration.frame->intrinsics, registration.centre.z()) <= kLeast_px;
}

/// How much a difference of intensity counts next to a distance. Of distances whose errors are alike, many say no more
/// than one. Distances that vary by less than their noise have less of that error. `before`: the sums of the round
/// before.
double colour_weight(const LevelPlan& plan, const IcpConfig& config, const Registration& registration,
                     const PairSums& before) {
  if (!is_colour_timely(config, registration)) return 1;
  const double variance = before.weights > 0 ? before.squares / before.weights : 1;  // in sigma
  return std::max(1.0, plan.alike * std::min(1.0, variance));
}

/// Moves the time of colour by a step, within what its standard deviation allows.
void move_colour(double by, const IcpConfig& config, Registration& registration) {
  constexpr double kMostSigmas = 3;
  const double most = config.moving ? kMostSigmas * config.moving->colour_sigma : 0;
  registration.colour_later = std::clamp(registration.colour_later + by, -most, most);
}

/// The prior that colour was taken when it was read for.
TimePrior time_prior(const IcpConfig& config, const Registration& registration, const PairSums& sums) {
  // Errors of neighbouring pixels are alike: all pairs say no more than so many independent ones.
  constexpr double kIndependent = 100;
  if (registration.colour_motion.is_still()) return {};
  const double sigma = config.moving->colour_sigma;
  const double weight = static_cast<double>(registration.gate.colour_weight) * sums.colour_weights;
  const double information = weight / (kIndependent * sigma * sigma);
  return {information, information * registration.colour_later};
}

/// What the pairs say of a motion in the frame's axes, of the whole of the points.
Matrix6d shape_of(const PairSums& sums, const Registration& registration) {
  if (!(sums.information > 0)) return Matrix6d::Zero();
  // A motion (v, w) of the frame moves its point p by R (v + w x p): as a translation at the centre, and a turn about
  // it.
  const Eigen::Matrix3d R = registration.T_model_frame.linear();
  const Eigen::Vector3d arm = registration.T_model_frame.inverse() * registration.centre;
  Matrix6d to_step = Matrix6d::Zero();
  to_step.topLeftCorner<3, 3>() = R;
  to_step.topRightCorner<3, 3>() = -R * cross_matrix(arm);
  to_step.bottomRightCorner<3, 3>() = registration.scale_m * R;
  return to_step.transpose() * (information_of(sums) / sums.information) * to_step;
}

/// IcpResult::colour_seems_later: one step for the pose and the time of colour together, without a prior. Depth holds
/// the pose meanwhile.
std::optional<double> colour_seems_later(const MovingCamera& moving, Registration registration) {
  constexpr double kLeastMotion_px = 1;
  registration.colour_motion = moving.motion(registration.T_model_frame);
  if (registration.colour_motion.pixels(registration.frame->intrinsics, registration.centre.z()) < kLeastMotion_px) {
    return std::nullopt;
  }
  registration.gate.colour_weight = 1;
  const PairSums sums = sum_pairs(registration);
  if (!(sums.colour_weights > kFewestPairs)) return std::nullopt;
  const Step step = solve(sums, {});
  return step.weak_directions == 0 ? std::optional(step.colour_later) : std::nullopt;
}

/// So small that the next round would change nothing that can be seen.
bool has_settled(const Step& step) {
  constexpr double kSettled_m = 5e-5;
  constexpr double kSettledTime = 0.02;  // of the time between frames
  return step.motion.norm() < kSettled_m && std::abs(step.colour_later) < kSettledTime;
}

}  // namespace

IcpResult register_frame(const SurfacePyramid& frame, const SurfacePyramid& model, const Pose& T_model_frame,
                         const IcpConfig& config) {
  IcpResult result;
  result.T_model_frame = T_model_frame;
  Registration registration;
  registration.noise = config.noise;
  const double depth_m = mean_depth(frame.levels.back());
  registration.scale_m = turning_scale(frame.levels.back(), depth_m);
  registration.centre = Eigen::Vector3d(0, 0, depth_m);
  registration.colour_later = config.colour_later;
  double intensity_offset = 0;
  PairSums sums;
  Step step;
  const auto look = [&](const LevelPlan& plan, int iteration) {
    registration.T_model_frame = result.T_model_frame;
    if (config.moving) take_motion(*config.moving, iteration >= plan.times_colour_from, registration);
    registration.gate = gate_of(plan, iteration, config, intensity_offset);
    registration.gate.colour_weight = static_cast<float>(colour_weight(plan, config, registration, sums));
    sums = sum_pairs(registration);
    step = solve(sums, time_prior(config, registration, sums));
  };
  const auto enter_level = [&](int level) {
    registration.frame = &frame.levels[static_cast<std::size_t>(level)];
    registration.model = &model.levels[static_cast<std::size_t>(level)];
  };
  for (int level = config.first_level; level >= config.last_level && !config.keeps_pose; --level) {
    const LevelPlan& plan = kPlans[static_cast<std::size_t>(level)];
    enter_level(level);
    for (int iteration = 0; iteration < plan.iterations; ++iteration) {
      look(plan, iteration);
      result.T_model_frame =
          motion_about(step.motion, registration.centre, registration.scale_m) * result.T_model_frame;
      move_colour(step.colour_later, config, registration);
      if (sums.colour_weights > kFewestPairs) intensity_offset = sums.colour_offset / sums.colour_weights;
      if (has_settled(step)) break;
    }
  }
  result.T_model_frame.linear() = Eigen::Quaterniond(result.T_model_frame.linear()).normalized().toRotationMatrix();
  if (config.keeps_pose || !has_settled(step)) {
    enter_level(config.last_level);
    const LevelPlan& last = kPlans[static_cast<std::size_t>(config.last_level)];
    look(last, last.iterations - 1);
  }
  describe(sums, step, result);
  if (config.asks_if_colour_is_late && config.moving) {
    registration.T_model_frame = result.T_model_frame;
    result.colour_seems_later = colour_seems_later(*config.moving, registration);
  }
  constexpr int kChangeLevel = 1;
  if (config.last_level < kChangeLevel) {
    result.changed_share = changed_share(frame.levels[kChangeLevel], model.levels[kChangeLevel], result.T_model_frame,
                                         registration.rows, config.noise);
  }
  result.shape = shape_of(sums, registration);
  result.centre = registration.centre;
  result.colour_later = registration.colour_later;
  Vector6d units = Vector6d::Ones();  // of rotation: radians, not metres at `scale_m`
  units.tail<3>().setConstant(registration.scale_m);
  result.information = units.asDiagonal() * step.information * units.asDiagonal();
  return result;
}

}  // namespace scanknit
