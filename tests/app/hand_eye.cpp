#include "tests/app/hand_eye.h"

#include <Eigen/Dense>
#include <cstddef>

namespace scanknit {
namespace {

/// How hand and camera moved between two moments.
struct Motion {
  Eigen::Isometry3d hand, camera;
};

std::vector<Motion> motions_of(const Poses& T_base_hand, const Poses& T_world_camera) {
  std::vector<Motion> motions;
  for (std::size_t i = 0; i < T_base_hand.size(); ++i) {
    for (std::size_t j = i + 1; j < T_base_hand.size(); ++j) {
      motions.push_back({T_base_hand[i].inverse() * T_base_hand[j], T_world_camera[i].inverse() * T_world_camera[j]});
    }
  }
  return motions;
}

Eigen::Vector3d turn(const Eigen::Isometry3d& motion) {
  const Eigen::AngleAxisd turned(motion.linear());
  return turned.angle() * turned.axis();
}

}  // namespace

Eigen::Isometry3d hand_eye(const Poses& T_base_hand, const Poses& T_world_camera) {
  const std::vector<Motion> motions = motions_of(T_base_hand, T_world_camera);
  // The hand's turns are the camera's, seen from the hand: the rotation that brings them together (Kabsch).
  Eigen::Matrix3d turns = Eigen::Matrix3d::Zero();
  for (const Motion& motion : motions) turns += turn(motion.hand) * turn(motion.camera).transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(turns, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant();
  const Eigen::Matrix3d R = svd.matrixU() * Eigen::Vector3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
  // (R_A - I) t = R t_B - t_A
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Motion& motion : motions) {
    const Eigen::Matrix3d left = motion.hand.linear() - Eigen::Matrix3d::Identity();
    normal += left.transpose() * left;
    right += left.transpose() * (R * motion.camera.translation() - motion.hand.translation());
  }
  Eigen::Isometry3d T_hand_camera = Eigen::Isometry3d::Identity();
  T_hand_camera.linear() = R;
  T_hand_camera.translation() = normal.ldlt().solve(right);
  return T_hand_camera;
}

}  // namespace scanknit
