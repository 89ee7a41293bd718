#include "calibrate/lens/bundle.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "calibrate/lens/levenberg_marquardt.h"

namespace scanknit {
namespace {

/// The normal equations of one view.
struct ViewEquations {
  LensMatrix lens = LensMatrix::Zero();
  Eigen::Matrix<double, 9, 6> mixed = Eigen::Matrix<double, 9, 6>::Zero();
  PoseMatrix pose = PoseMatrix::Zero();
  LensVector lens_pull = LensVector::Zero();
  PoseVector pose_pull = PoseVector::Zero();
};

Eigen::Vector3d in_camera(const BundleView& view, std::size_t corner) {
  const Eigen::Vector2d& p = view.board_m[corner];
  return view.T_camera_board * Eigen::Vector3d(p.x(), p.y(), 0);
}

/// Half of Huber's cost; infinite if a corner is behind the camera.
double cost_of(const Bundle& bundle, double huber_px) {
  double cost = 0;
  for (const BundleView& view : bundle.views) {
    for (const Eigen::Vector2d& residual : residuals(bundle.lens, view)) {
      const double length = residual.norm();
      cost += length <= huber_px ? length * length / 2 : huber_px * (length - huber_px / 2);
    }
  }
  return cost;
}

ViewEquations equations_of(const LensVector& lens, const BundleView& view, FreeLens free, double huber_px) {
  ViewEquations equations;
  const auto held = 9 - static_cast<Eigen::Index>(free);
  for (std::size_t i = 0; i < view.board_m.size(); ++i) {
    Projection at = project(lens, in_camera(view, i));
    const Eigen::Vector2d residual = view.pixels[i] - at.pixel;
    const double weight = std::min(1.0, huber_px / std::max(residual.norm(), 1e-12));
    at.by_lens.rightCols(held).setZero();
    equations.lens += weight * at.by_lens.transpose() * at.by_lens;
    equations.mixed += weight * at.by_lens.transpose() * at.by_pose;
    equations.pose += weight * at.by_pose.transpose() * at.by_pose;
    equations.lens_pull += weight * at.by_lens.transpose() * residual;
    equations.pose_pull += weight * at.by_pose.transpose() * residual;
  }
  return equations;
}

/// The bundle after one damped step.
Bundle stepped(const Bundle& bundle, std::vector<ViewEquations> all, FreeLens free, double damping) {
  LensMatrix reduced = LensMatrix::Zero();
  LensVector pull = LensVector::Zero();
  std::vector<Eigen::LDLT<PoseMatrix>> poses;
  for (ViewEquations& view : all) {
    reduced += view.lens;
    view.pose.diagonal() *= 1 + damping;
  }
  reduced.diagonal() *= 1 + damping;
  for (const ViewEquations& view : all) {
    const auto& pose = poses.emplace_back(view.pose);
    reduced -= view.mixed * pose.solve(view.mixed.transpose());
    pull += view.lens_pull - view.mixed * pose.solve(view.pose_pull);
  }
  reduced.diagonal().tail(9 - static_cast<Eigen::Index>(free)).setOnes();
  const LensVector lens_step = reduced.ldlt().solve(pull);
  Bundle next = bundle;
  next.lens += lens_step;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const PoseVector step = poses[i].solve(all[i].pose_pull - all[i].mixed.transpose() * lens_step);
    next.views[i].T_camera_board = moved(step, bundle.views[i].T_camera_board);
  }
  return next;
}

}  // namespace

Pose moved(const PoseVector& step, const Pose& pose) {
  const Eigen::Vector3d turn = step.tail<3>();
  const double angle = turn.norm();
  Pose motion = Pose::Identity();
  if (angle > 0) motion.linear() = Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
  motion.translation() = step.head<3>();
  Pose result = motion * pose;
  result.linear() = Eigen::Quaterniond(result.linear()).normalized().toRotationMatrix();  // rounding does not add up
  return result;
}

PoseMatrix step_seen_from(const Pose& T_other_frame) {
  const Eigen::Matrix3d& R = T_other_frame.linear();
  const Eigen::Vector3d& t = T_other_frame.translation();
  Eigen::Matrix3d cross;
  cross << 0, -t.z(), t.y(), t.z(), 0, -t.x(), -t.y(), t.x(), 0;
  PoseMatrix m = PoseMatrix::Zero();
  m.topLeftCorner<3, 3>() = R;
  m.topRightCorner<3, 3>() = cross * R;
  m.bottomRightCorner<3, 3>() = R;
  return m;
}

std::vector<Eigen::Vector2d> residuals(const LensVector& lens, const BundleView& view) {
  std::vector<Eigen::Vector2d> result;
  result.reserve(view.board_m.size());
  for (std::size_t i = 0; i < view.board_m.size(); ++i) {
    const Eigen::Vector3d p_camera = in_camera(view, i);
    const bool is_in_front = p_camera.z() > 0;
    result.push_back(is_in_front ? Eigen::Vector2d(view.pixels[i] - project(lens, p_camera).pixel)
                                 : Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity()));
  }
  return result;
}

PoseMatrix pose_information(const LensVector& lens, const BundleView& view) {
  return equations_of(lens, view, FreeLens::kNone, kNoHuber).pose;
}

LensMatrix information(const LensVector& lens, const BundleView& view, FreeLens free) {
  const ViewEquations equations = equations_of(lens, view, free, kNoHuber);
  return equations.lens - equations.mixed * equations.pose.ldlt().solve(equations.mixed.transpose());
}

void optimise(Bundle& bundle, FreeLens free, double huber_px) {
  const auto equations = [&](const Bundle& at) {
    std::vector<ViewEquations> all;
    for (const BundleView& view : at.views) all.push_back(equations_of(at.lens, view, free, huber_px));
    return all;
  };
  const auto next = [&](const Bundle& at, const std::vector<ViewEquations>& all, double damping) {
    return stepped(at, all, free, damping);
  };
  descend(
      bundle, [&](const Bundle& at) { return cost_of(at, huber_px); }, equations, next);
}

}  // namespace scanknit
