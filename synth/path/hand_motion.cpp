#include "synth/path/hand_motion.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/counter_random.h"
#include "core/rotation.h"

namespace scanknit {
namespace {

using Eigen::Vector3d;

constexpr double kBraking_s = 0.4;
constexpr std::uint64_t kWobbleStream = 0x0B'B1E;  // streams of random numbers
constexpr std::uint64_t kTurnStream = 0x7E'4B5;
constexpr std::uint64_t kStopStream = 0x57'0B5;

double between(CounterRandom& random, double low, double high) {
  return low + (high - low) * random.uniform();
}

/// From 0 at 0 to 1 at 1 with the least jerk (Flash and Hogan 1985): its steepest slope is 1.875.
double least_jerk(double x) {
  const double u = std::clamp(x, 0.0, 1.0);
  return u * u * u * (10 + u * (6 * u - 15));
}
constexpr double kSteepest = 1.875;

/// The smooth step 3u^2 - 2u^3, and its integral from 0.
double ramp(double x) {
  const double u = std::clamp(x, 0.0, 1.0);
  return u * u * (3 - 2 * u);
}
double ramp_integral(double x) {
  const double u = std::clamp(x, 0.0, 1.0);
  return u * u * u * (1 - u / 2);
}

Pose turned(const Vector3d& angles_rad) {
  Pose pose = Pose::Identity();
  const double angle = angles_rad.norm();
  if (angle > 0) pose.linear() = Eigen::AngleAxisd(angle, angles_rad / angle).toRotationMatrix();
  return pose;
}

Pose shifted(const Vector3d& by_m) {
  Pose pose = Pose::Identity();
  pose.translation() = by_m;
  return pose;
}

}  // namespace

Wobble::Wobble(double deviation, double lowest_hz, double highest_hz, std::uint64_t seed, std::uint64_t channel) {
  CounterRandom random(seed, kWobbleStream, channel);
  const double amplitude = deviation * std::sqrt(2.0 / static_cast<double>(waves_.size()));
  for (Wave& wave : waves_) {
    wave = {amplitude, kFullTurn * between(random, lowest_hz, highest_hz), kFullTurn * random.uniform()};
  }
}

double Wobble::at(double time_s) const {
  double sum = 0;
  for (const Wave& wave : waves_) sum += wave.amplitude * std::sin(wave.speed_rad_s * time_s + wave.phase_rad);
  return sum;
}

HandMotion::HandMotion(CameraPath path, const MotionConfig& config)
    : path_(std::move(path)), config_(config), duration_s_(config.frames / config.frames_per_second) {
  for (std::uint64_t axis = 0; axis < 3; ++axis) {
    shifts_m_.emplace_back(0.006, 0.15, 0.9, config.seed, 4 * axis);
    shifts_m_.emplace_back(0.0003, 8, 12, config.seed, 4 * axis + 1);
    turns_rad_.emplace_back(0.8 * kDegree, 0.2, 1.2, config.seed, 4 * axis + 2);
    turns_rad_.emplace_back(0.05 * kDegree, 8, 12, config.seed, 4 * axis + 3);
  }
  if (config.kind == PathKind::kTurns) draw_turns();
  if (config.kind == PathKind::kWalk) draw_stops();
}

void HandMotion::draw_turns() {
  double time_s = 1;
  for (std::uint64_t number = 0; time_s < duration_s_; ++number) {
    CounterRandom random(config_.seed, kTurnStream, number);
    const double side = random.uniform() < 0.5 ? -1 : 1;
    const double angle_rad = between(random, 40, 75) * kDegree;
    const double rate_rad_s = between(random, 0.75, 1) * kFastestTurn_rad_s;
    const double way_s = kSteepest * angle_rad / rate_rad_s;
    looks_aside_.push_back({time_s, side * angle_rad, way_s, between(random, 0.2, 0.6)});
    time_s += 2 * way_s + looks_aside_.back().rest_s + between(random, 0.8, 2);
  }
}

void HandMotion::draw_stops() {
  double time_s = 2;
  for (std::uint64_t number = 0; time_s + 4 < duration_s_; ++number) {
    CounterRandom random(config_.seed, kStopStream, number);
    stops_.push_back({time_s, between(random, 1, 2)});
    time_s += 2 * kBraking_s + stops_.back().rest_s + between(random, 2, 5);
  }
}

double HandMotion::pace(double time_s) const {
  double pace = 1;
  for (const Stop& stop : stops_) {
    const double since = time_s - stop.begin_s;
    pace -= ramp(since / kBraking_s) - ramp((since - kBraking_s - stop.rest_s) / kBraking_s);
  }
  return pace;
}

/// The integral of 1 - pace().
double HandMotion::lost_s(double time_s) const {
  double lost = 0;
  for (const Stop& stop : stops_) {
    const double since = time_s - stop.begin_s;
    const double rest = std::clamp(since - kBraking_s, 0.0, stop.rest_s);
    const double leaving = std::clamp((since - kBraking_s - stop.rest_s) / kBraking_s, 0.0, 1.0);
    lost += rest + kBraking_s * (ramp_integral(since / kBraking_s) + leaving - ramp_integral(leaving));
  }
  return lost;
}

double HandMotion::yaw_rad(double time_s) const {
  double yaw = 0;
  for (const Turn& turn : looks_aside_) {
    const double since = time_s - turn.begin_s;
    yaw +=
        turn.angle_rad * (least_jerk(since / turn.way_s) - least_jerk((since - turn.way_s - turn.rest_s) / turn.way_s));
  }
  return yaw;
}

/// The wrist's circle of 8 cm in 2.5 s about the line of sight, looking at a point 0.9 m ahead.
Pose HandMotion::wrist(double time_s) const {
  constexpr double kRadius_m = 0.08;
  constexpr double kPeriod_s = 2.5;
  constexpr double kAhead_m = 0.9;
  const double angle = kFullTurn * time_s / kPeriod_s;
  const Vector3d place = kRadius_m * Vector3d(std::cos(angle) - 1, std::sin(angle), 0);
  const Pose towards = turned(Vector3d(place.y(), -place.x(), 0) / kAhead_m);
  return shifted(place) * towards;
}

Pose HandMotion::along_path(double time_s) const {
  if (config_.kind == PathKind::kOrbit) return path_(0) * wrist(time_s);
  const double walked = (time_s - lost_s(time_s)) / (duration_s_ - lost_s(duration_s_));
  Pose pose = path_(walked);
  if (config_.kind == PathKind::kWalk) {
    constexpr double kSteps_hz = 1.8;
    constexpr double kLift_m = 0.018;
    const double phase = kFullTurn * kSteps_hz * time_s;
    pose.translation() += pace(time_s) * kLift_m * Vector3d(0, std::cos(phase), 0);
    pose = pose * shifted({pace(time_s) * kLift_m * std::sin(phase / 2), 0, 0});
  }
  return pose;
}

Pose HandMotion::operator()(double frame) const {
  const double time_s = frame / config_.frames_per_second;
  Pose pose = along_path(time_s);
  // Looking aside turns about the vertical of the world, whose y axis points down.
  pose.linear() = Eigen::AngleAxisd(yaw_rad(time_s), Vector3d::UnitY()).toRotationMatrix() * pose.linear();
  Vector3d shift = Vector3d::Zero();
  Vector3d turn = Vector3d::Zero();
  for (std::size_t i = 0; i < shifts_m_.size(); ++i) {
    const auto axis = static_cast<Eigen::Index>(i / 2);
    shift[axis] += shifts_m_[i].at(time_s);
    turn[axis] += turns_rad_[i].at(time_s);
  }
  return pose * shifted(shift) * turned(turn);
}

}  // namespace scanknit
