#include "calibrate/lens/homography.h"

#include <Eigen/Eigenvalues>
#include <numbers>

namespace scanknit {
namespace {

/// Moves the mean to 0 and makes the mean distance from it the square root of 2.
Eigen::Matrix3d normalisation(const std::vector<Eigen::Vector2d>& points) {
  const auto count = static_cast<double>(points.size());
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& point : points) mean += point / count;
  double distance = 0;
  for (const Eigen::Vector2d& point : points) distance += (point - mean).norm() / count;
  const double scale = distance > 0 ? std::numbers::sqrt2 / distance : 1;
  Eigen::Matrix3d T = Eigen::Matrix3d::Identity();
  T.topLeftCorner<2, 2>() *= scale;
  T.topRightCorner<2, 1>() = -scale * mean;
  return T;
}

}  // namespace

Eigen::Matrix3d fit_homography(const std::vector<Eigen::Vector2d>& plane, const std::vector<Eigen::Vector2d>& pixels) {
  const Eigen::Matrix3d T_plane = normalisation(plane);
  const Eigen::Matrix3d T_pixels = normalisation(pixels);
  Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
  for (std::size_t i = 0; i < plane.size(); ++i) {
    const Eigen::Vector3d p = (T_plane * plane[i].homogeneous()).eval();
    const Eigen::Vector2d q = apply(T_pixels, pixels[i]);
    Eigen::Matrix<double, 2, 9> rows;
    rows << p.transpose(), Eigen::RowVector3d::Zero(), -q.x() * p.transpose(),  //
        Eigen::RowVector3d::Zero(), p.transpose(), -q.y() * p.transpose();
    normal += rows.transpose() * rows;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> solver(normal);
  const Eigen::Matrix<double, 9, 1> h = solver.eigenvectors().col(0);
  Eigen::Matrix3d H;
  H << h.segment<3>(0).transpose(), h.segment<3>(3).transpose(), h.segment<3>(6).transpose();
  H = (T_pixels.inverse() * H * T_plane).eval();
  return H / H.norm();
}

}  // namespace scanknit
