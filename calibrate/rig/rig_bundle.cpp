#include "calibrate/rig/rig_bundle.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "calibrate/lens/levenberg_marquardt.h"

namespace scanknit {
namespace {

using CameraMatrix = Eigen::Matrix<double, kRigNumbers, kRigNumbers>;
using CameraVector = Eigen::Matrix<double, kRigNumbers, 1>;
using CameraByBoard = Eigen::Matrix<double, kRigNumbers, 6>;
constexpr Eigen::Index kPoseAt = 9, kClockAt = 15;

// A clock that no motion tells of stays where it is: steps are held as if it were known to 0.1 s where corners are to a
// pixel.
constexpr double kClockHold = 100;

/// The normal equations of one moment.
struct MomentEquations {
  PoseMatrix board = PoseMatrix::Zero();
  PoseVector board_pull = PoseVector::Zero();
  std::vector<CameraByBoard> mixed;  ///< of each sighting
};

struct RigEquations {
  std::vector<CameraMatrix> cameras;
  std::vector<CameraVector> pulls;
  std::vector<MomentEquations> moments;
};

struct Reduced {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd pull;
  std::vector<Eigen::LDLT<PoseMatrix>> boards;
};

/// Which numbers of a camera are free.
Eigen::Array<bool, kRigNumbers, 1> free_of(const RigBundle& bundle, std::size_t camera) {
  Eigen::Array<bool, kRigNumbers, 1> free;
  free.setConstant(camera > 0);
  free.head(kPoseAt).setConstant(false);
  free.head(static_cast<Eigen::Index>(bundle.cameras[camera].free)).setConstant(true);
  return free;
}

double cost_of(const RigBundle& bundle, double huber_px) {
  double cost = 0;
  for (const RigMoment& moment : bundle.moments) {
    for (const RigSighting& sighting : moment.sightings) {
      for (const Eigen::Vector2d& residual : residuals(bundle, moment, sighting)) {
        const double length = residual.norm();
        cost += length <= huber_px ? length * length / 2 : huber_px * (length - huber_px / 2);
      }
    }
  }
  return cost;
}

void add_sighting(const RigBundle& bundle, const RigMoment& moment, const RigSighting& sighting, double huber_px,
                  RigEquations& all, MomentEquations& own) {
  const RigBundleCamera& camera = bundle.cameras[sighting.camera];
  const auto free = free_of(bundle, sighting.camera);
  const PoseMatrix by_board_step = step_seen_from(camera.T_camera_rig);
  const Pose T_camera_board = camera.T_camera_rig * moment.T_rig_board;
  CameraMatrix& matrix = all.cameras[sighting.camera];
  CameraVector& pull = all.pulls[sighting.camera];
  CameraByBoard& mixed = own.mixed.emplace_back(CameraByBoard::Zero());
  for (std::size_t i = 0; i < sighting.board_m.size(); ++i) {
    const Eigen::Vector2d& p = sighting.board_m[i];
    const Projection at = project(camera.lens, T_camera_board * Eigen::Vector3d(p.x(), p.y(), 0));
    Eigen::Matrix<double, 2, kRigNumbers> by_camera;
    by_camera << at.by_lens, at.by_pose, -sighting.pixels_per_s[i];
    for (Eigen::Index k = 0; k < kRigNumbers; ++k) {
      if (!free[k]) by_camera.col(k).setZero();
    }
    const Eigen::Matrix<double, 2, 6> by_board = at.by_pose * by_board_step;
    const Eigen::Vector2d residual = sighting.pixels[i] + camera.late_s * sighting.pixels_per_s[i] - at.pixel;
    const double weight = std::min(1.0, huber_px / std::max(residual.norm(), 1e-12));
    matrix += weight * by_camera.transpose() * by_camera;
    mixed += weight * by_camera.transpose() * by_board;
    own.board += weight * by_board.transpose() * by_board;
    pull += weight * by_camera.transpose() * residual;
    own.board_pull += weight * by_board.transpose() * residual;
  }
}

RigEquations equations_of(const RigBundle& bundle, double huber_px) {
  RigEquations all;
  all.cameras.assign(bundle.cameras.size(), CameraMatrix::Zero());
  all.pulls.assign(bundle.cameras.size(), CameraVector::Zero());
  for (const RigMoment& moment : bundle.moments) {
    MomentEquations& own = all.moments.emplace_back();
    for (const RigSighting& sighting : moment.sightings) add_sighting(bundle, moment, sighting, huber_px, all, own);
  }
  return all;
}

/// The equations of the cameras alone.
Reduced reduced_of(const RigBundle& bundle, const RigEquations& all, double damping) {
  const auto size = kRigNumbers * static_cast<Eigen::Index>(bundle.cameras.size());
  Reduced reduced{Eigen::MatrixXd::Zero(size, size), Eigen::VectorXd::Zero(size), {}};
  const auto place = [](std::size_t camera) { return kRigNumbers * static_cast<Eigen::Index>(camera); };
  for (std::size_t camera = 0; camera < bundle.cameras.size(); ++camera) {
    CameraMatrix matrix = all.cameras[camera];
    matrix(kClockAt, kClockAt) += kClockHold;
    matrix.diagonal() *= 1 + damping;
    const auto free = free_of(bundle, camera);
    for (Eigen::Index k = 0; k < kRigNumbers; ++k) {
      if (!free[k]) matrix(k, k) = 1;
    }
    reduced.matrix.block<kRigNumbers, kRigNumbers>(place(camera), place(camera)) = matrix;
    reduced.pull.segment<kRigNumbers>(place(camera)) = all.pulls[camera];
  }
  for (std::size_t m = 0; m < bundle.moments.size(); ++m) {
    const auto& sightings = bundle.moments[m].sightings;
    PoseMatrix damped = all.moments[m].board;
    damped.diagonal() *= 1 + damping;
    const auto& board = reduced.boards.emplace_back(damped);
    for (std::size_t i = 0; i < sightings.size(); ++i) {
      const Eigen::Index row = place(sightings[i].camera);
      const Eigen::Matrix<double, 6, kRigNumbers> solved = board.solve(all.moments[m].mixed[i].transpose());
      reduced.pull.segment<kRigNumbers>(row) -= solved.transpose() * all.moments[m].board_pull;
      for (std::size_t k = 0; k < sightings.size(); ++k) {
        reduced.matrix.block<kRigNumbers, kRigNumbers>(row, place(sightings[k].camera)) -=
            solved.transpose() * all.moments[m].mixed[k].transpose();
      }
    }
  }
  return reduced;
}

RigBundle stepped(const RigBundle& bundle, const RigEquations& all, double damping) {
  const Reduced reduced = reduced_of(bundle, all, damping);
  const Eigen::VectorXd step = reduced.matrix.ldlt().solve(reduced.pull);
  const auto step_of = [&](std::size_t camera) -> CameraVector {
    return step.segment<kRigNumbers>(kRigNumbers * static_cast<Eigen::Index>(camera));
  };
  RigBundle next = bundle;
  for (std::size_t camera = 0; camera < bundle.cameras.size(); ++camera) {
    RigBundleCamera& changed = next.cameras[camera];
    const CameraVector own = step_of(camera);
    changed.lens += own.head<kPoseAt>();
    changed.T_camera_rig = moved(own.segment<6>(kPoseAt), changed.T_camera_rig);
    changed.late_s += own[kClockAt];
  }
  for (std::size_t m = 0; m < bundle.moments.size(); ++m) {
    PoseVector pull = all.moments[m].board_pull;
    for (std::size_t i = 0; i < bundle.moments[m].sightings.size(); ++i) {
      pull -= all.moments[m].mixed[i].transpose() * step_of(bundle.moments[m].sightings[i].camera);
    }
    next.moments[m].T_rig_board = moved(reduced.boards[m].solve(pull), bundle.moments[m].T_rig_board);
  }
  return next;
}

}  // namespace

std::vector<Eigen::Vector2d> residuals(const RigBundle& bundle, const RigMoment& moment, const RigSighting& sighting) {
  const RigBundleCamera& camera = bundle.cameras[sighting.camera];
  BundleView view{sighting.board_m, sighting.pixels, camera.T_camera_rig * moment.T_rig_board};
  for (std::size_t i = 0; i < view.pixels.size(); ++i) view.pixels[i] += camera.late_s * sighting.pixels_per_s[i];
  return residuals(camera.lens, view);
}

void optimise(RigBundle& bundle, double huber_px) {
  descend(
      bundle, [&](const RigBundle& at) { return cost_of(at, huber_px); },
      [&](const RigBundle& at) { return equations_of(at, huber_px); }, stepped);
}

Eigen::MatrixXd covariance(const RigBundle& bundle) {
  const Eigen::MatrixXd matrix = reduced_of(bundle, equations_of(bundle, kNoHuber), 0).matrix;
  const Eigen::VectorXd units = matrix.diagonal().cwiseSqrt().cwiseInverse();  // fx and k2 are 1e10 apart
  const Eigen::MatrixXd scaled = units.asDiagonal() * matrix * units.asDiagonal();
  Eigen::MatrixXd result = scaled.ldlt().solve(Eigen::MatrixXd::Identity(matrix.rows(), matrix.cols()));
  result = units.asDiagonal() * result * units.asDiagonal();
  for (std::size_t camera = 0; camera < bundle.cameras.size(); ++camera) {
    const auto free = free_of(bundle, camera);
    for (Eigen::Index k = 0; k < kRigNumbers; ++k) {
      const Eigen::Index at = kRigNumbers * static_cast<Eigen::Index>(camera) + k;
      if (!free[k]) result.row(at).setZero(), result.col(at).setZero();
    }
  }
  return result;
}

}  // namespace scanknit
