#include "calibrate/lens/first_guess.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <cmath>

#include "calibrate/lens/homography.h"

namespace scanknit {

// With w = 1 / f^2 and h the columns of the homography in pixels from the centre: h1' diag(w, w, 1) h2 = 0 and
// h1' diag(w, w, 1) h1 = h2' diag(w, w, 1) h2: two equations a w = b of each view, weighted alike.
LensVector guess_lens(const std::vector<BundleView>& views, int width, int height) {
  const Eigen::Vector2d centre((width - 1) / 2.0, (height - 1) / 2.0);
  double squares = 0, products = 0;
  for (const BundleView& view : views) {
    std::vector<Eigen::Vector2d> pixels = view.pixels;
    for (Eigen::Vector2d& pixel : pixels) pixel = (pixel - centre) / width;
    const Eigen::Matrix3d H = fit_homography(view.board_m, pixels);
    const double length = H.leftCols<2>().norm();
    const Eigen::Vector3d h1 = H.col(0) / length;
    const Eigen::Vector3d h2 = H.col(1) / length;
    const Eigen::Vector2d a(h1.head<2>().dot(h2.head<2>()), h1.head<2>().squaredNorm() - h2.head<2>().squaredNorm());
    const Eigen::Vector2d b(-h1.z() * h2.z(), h2.z() * h2.z() - h1.z() * h1.z());
    squares += a.squaredNorm();
    products += a.dot(b);
  }
  constexpr double kShortest = 0.2, kLongest = 10;  // of the width: lenses of 136 to 6 degrees
  const double focal = squares > 0 && products > 0 ? std::sqrt(squares / products) : 1;
  LensVector lens = LensVector::Zero();
  lens.head<2>().setConstant(width * (focal > kShortest && focal < kLongest ? focal : 1));
  lens.segment<2>(2) = centre;
  return lens;
}

Pose guess_pose(const LensVector& lens, const BundleView& view) {
  std::vector<Eigen::Vector2d> ideal;
  for (const Eigen::Vector2d& pixel : view.pixels) ideal.push_back(straighten(lens, pixel));
  Eigen::Matrix3d H = fit_homography(view.board_m, ideal);
  H /= (H.col(0).norm() + H.col(1).norm()) / 2;
  if (H(2, 2) < 0) H = -H;  // in front of the camera
  Eigen::Matrix3d R;
  R << H.col(0), H.col(1), H.col(0).cross(H.col(1));
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Pose pose = Pose::Identity();
  pose.linear() = svd.matrixU() * svd.matrixV().transpose();
  pose.translation() = H.col(2);
  Bundle one{lens, {view}};
  one.views.front().T_camera_board = pose;
  constexpr double kHuber_px = 3;  // a corner may be another one
  optimise(one, FreeLens::kNone, kHuber_px);
  return one.views.front().T_camera_board;
}

}  // namespace scanknit
