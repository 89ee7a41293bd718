#include "core/pose.h"

#include <Eigen/SVD>
#include <cmath>

namespace scanknit {
namespace {

constexpr double kFileTolerance = 0.01;   // printed matrices carry 3 or more digits
constexpr double kFarthest_m = 1e9;       // what is farther is a damaged file, and sums of it are not finite
constexpr double kRigidTolerance = 1e-6;  // what arithmetic in double leaves behind

double orthogonality_error(const Eigen::Matrix3d& r) {
  return (r.transpose() * r - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
}

}  // namespace

Result<Pose> pose_from_matrix(const Eigen::Matrix4d& matrix) {
  if (!matrix.allFinite()) return Error{ErrorCode::kInput, "the pose holds a value that is not finite"};
  if ((matrix.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() > kFileTolerance) {
    return Error{ErrorCode::kInput, "the pose's last row is not 0 0 0 1"};
  }
  const Eigen::Matrix3d r = matrix.topLeftCorner<3, 3>();
  if (orthogonality_error(r) > kFileTolerance) {
    return Error{ErrorCode::kInput, "the pose is not rigid: its 3x3 part is not a rotation"};
  }
  if (r.determinant() < 0) return Error{ErrorCode::kInput, "the pose is not rigid: it mirrors (determinant -1)"};
  if (matrix.topRightCorner<3, 1>().cwiseAbs().maxCoeff() > kFarthest_m) {
    return Error{ErrorCode::kInput, "the pose is more than 1,000,000 km away; expected metres"};
  }

  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(r, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Pose pose = Pose::Identity();
  pose.linear() = svd.matrixU() * svd.matrixV().transpose();
  pose.translation() = matrix.topRightCorner<3, 1>();
  return pose;
}

Pose interpolate(const Pose& from, const Pose& to, double fraction) {
  const Eigen::Quaterniond q_from(from.linear());
  const Eigen::Quaterniond q_to(to.linear());
  Pose pose = Pose::Identity();
  pose.linear() = q_from.slerp(fraction, q_to).toRotationMatrix();
  pose.translation() = from.translation() + fraction * (to.translation() - from.translation());
  return pose;
}

bool is_rigid(const Pose& pose) {
  return pose.matrix().allFinite() && orthogonality_error(pose.linear()) <= kRigidTolerance &&
         pose.linear().determinant() > 0;
}

}  // namespace scanknit
