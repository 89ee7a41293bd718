#include "synth/turntable_rig.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/check.h"
#include "core/counter_random.h"
#include "core/rotation.h"
#include "synth/scene/analytic_scene.h"
#include "synth/scene/camera_paths.h"
#include "synth/scene/surface_samples.h"

namespace scanknit {
namespace {

using Eigen::Vector3d;

constexpr std::uint64_t kAngleStream = 0x7AB1E;  // stream of random numbers

constexpr double kDiscThickness_m = 0.015;
constexpr double kElevation_rad = 28 * kDegree;  // the camera looks down from this elevation
constexpr double kRoll_rad = 4 * kDegree;

Texture plain(double shade) {
  const Vector3d grey(shade, 0.97 * shade, 0.92 * shade);
  return {.dark = grey, .light = grey, .pattern = Pattern::kChecks, .period_m = 0.05};
}

Texture printed(double shade) {
  return {.dark = Vector3d(0.5, 0.7, 0.9) * shade,
          .light = Vector3d(1, 0.9, 0.7) * shade,
          .pattern = Pattern::kMarble,
          .period_m = 0.03};
}

/// Converts from the table's axes (z up), in which the rig is drawn, to the renderer's world (y down).
Pose in_world(const Vector3d& centre) {
  Pose pose = Pose::Identity();
  pose.translation() = centre;
  return T_world_plan() * pose;
}

Pose turned(double angle_rad) {
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::AngleAxisd(angle_rad, Vector3d::UnitZ()).toRotationMatrix();
  return pose;
}

CameraPath no_path() {
  return [](double) { return Pose::Identity(); };
}

}  // namespace

TurntableRig::TurntableRig(const SyntheticScene& object, const RigConfig& config, int frames, std::uint64_t seed)
    : object_(object), config_(config), frames_(frames), seed_(seed) {
  SCANKNIT_CHECK(frames >= 1);
  // The object stands as the scene is drawn, or lies on its side, rotated a little.
  T_table_object_ = T_world_plan().inverse();
  if (config.is_on_side) {
    T_table_object_ = turned(40 * kDegree) * Pose(Eigen::AngleAxisd(90 * kDegree, Vector3d::UnitX())) * T_table_object_;
  }
  constexpr std::size_t kSamples = 20'000;
  Eigen::AlignedBox3d box;
  const std::vector<TruthPoint> samples = sample_surface(object, kSamples, /*seed=*/1);
  for (const TruthPoint& point : samples) box.extend(T_table_object_ * point.position_m.cast<double>());
  const double size_m = box.diagonal().norm();
  const Vector3d off_axis = size_m * Vector3d(0.03, -0.045, 0);
  const Vector3d foot(box.center().x(), box.center().y(), box.min().z());
  T_table_object_.pretranslate(off_axis - foot);
  height_m_ = box.max().z() - box.min().z();
  for (const TruthPoint& point : samples) {
    reach_m_ = std::max(reach_m_, (T_table_object_ * point.position_m.cast<double>()).head<2>().norm());
  }

  const double distance_m = std::max(0.45, 1.9 * size_m);
  const Vector3d target(0.02 * size_m, -0.03 * size_m, 0.45 * height_m_);
  const Vector3d eye = target + distance_m * Vector3d(0.2 * std::cos(kElevation_rad), -0.98 * std::cos(kElevation_rad),
                                                      std::sin(kElevation_rad));
  T_table_camera_ =
      T_world_plan().inverse() * look_at(eye, target) * Pose(Eigen::AngleAxisd(kRoll_rad, Vector3d::UnitZ()));

  std::vector<Solid> solids;
  const double disc_m = reach_m_ + 0.02;
  solids.emplace_back(Cylinder{disc_m, kDiscThickness_m / 2, 0.002}, in_world({0, 0, -kDiscThickness_m / 2}),
                      plain(0.75));
  solids.emplace_back(Box{{disc_m + 0.15, disc_m + 0.10, 0.02}, 0.003}, in_world({0, 0, -kDiscThickness_m - 0.019}),
                      printed(0.8));
  solids.emplace_back(Box{{disc_m + 0.4, 0.02, 0.4}, 0.003}, in_world({0, disc_m + 0.16, 0.1}), printed(0.6));
  solids.emplace_back(Box{{0.03, 0.03, 0.05}, 0.003}, in_world({-disc_m - 0.08, 0.03, 0.03}), printed(0.9));
  still_ = std::make_unique<AnalyticScene>("still", no_path(), 1, std::move(solids));
}

double TurntableRig::steady_angle_rad(std::size_t frame) const {
  return kFullTurn * config_.turns * static_cast<double>(frame) / frames_;
}

double TurntableRig::angle_rad(std::size_t frame) const {
  CounterRandom random(seed_, kAngleStream, frame);
  return steady_angle_rad(frame) + config_.angle_noise_rad * random.gaussian();
}

Pose TurntableRig::T_object_camera(std::size_t frame) const {
  return (turned(angle_rad(frame)) * T_table_object_).inverse() * T_table_camera_;
}

/// The position of the hand; nothing most of the time.
std::optional<Vector3d> TurntableRig::fist(std::size_t frame) const {
  constexpr double kFirst = 0.30;  // share of the recording
  constexpr double kLast = 0.40;
  const double s = (static_cast<double>(frame) / frames_ - kFirst) / (kLast - kFirst);
  if (!config_.has_hand || s < 0 || s > 1) return std::nullopt;
  const double away_m = 0.10 * std::abs(2 * s - 1);  // moves in and out
  return Vector3d(reach_m_ + 0.03 + away_m, -0.02, 0.5 * height_m_ + 0.02);
}

RenderedView TurntableRig::render(const CameraIntrinsics& camera, std::size_t frame) const {
  RenderedView view = scanknit::render(*still_, camera, T_world_plan() * T_table_camera_);
  put_in_front(scanknit::render(object_, camera, T_object_camera(frame)), view);
  if (const auto at = fist(frame)) {
    std::vector<Solid> solids;
    Pose arm = in_world(*at + Vector3d(0.12, 0, 0.03));
    arm.linear() = arm.linear() * Eigen::AngleAxisd(76 * kDegree, Vector3d::UnitY()).toRotationMatrix();
    solids.emplace_back(Sphere{0.035}, in_world(*at), printed(0.95));
    solids.emplace_back(Cylinder{0.022, 0.13, 0.004}, arm, printed(0.7));
    const AnalyticScene hand("hand", no_path(), 1, std::move(solids));
    put_in_front(scanknit::render(hand, camera, T_world_plan() * T_table_camera_), view);
  }
  return view;
}

}  // namespace scanknit
