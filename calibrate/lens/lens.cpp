#include "calibrate/lens/lens.h"

#include <algorithm>

namespace scanknit {

LensVector lens_of(const CameraModel& model) {
  const CameraIntrinsics& k = model.intrinsics;
  LensVector lens;
  lens << k.fx, k.fy, k.cx, k.cy, Eigen::Map<const Eigen::Matrix<double, 5, 1>>(model.distortion.data());
  return lens;
}

CameraModel model_of(const LensVector& lens, int width, int height) {
  CameraModel model{{width, height, lens[0], lens[1], lens[2], lens[3]}, {}};
  std::copy(lens.data() + 4, lens.data() + 9, model.distortion.begin());
  return model;
}

Projection project(const LensVector& lens, const Eigen::Vector3d& p_camera) {
  const double z = p_camera.z();
  const double x = p_camera.x() / z;
  const double y = p_camera.y() / z;
  const double r2 = x * x + y * y;
  const double k1 = lens[4], k2 = lens[5], p1 = lens[6], p2 = lens[7], k3 = lens[8];
  const double stretch = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double steep = k1 + r2 * (2 * k2 + 3 * r2 * k3);  // of the stretch, by r2
  const double bent_x = x * stretch + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
  const double bent_y = y * stretch + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;

  Projection result;
  result.pixel = {lens[0] * bent_x + lens[2], lens[1] * bent_y + lens[3]};
  result.by_lens.row(0) << bent_x, 0, 1, 0, lens[0] * x * r2, lens[0] * x * r2 * r2, lens[0] * 2 * x * y,
      lens[0] * (r2 + 2 * x * x), lens[0] * x * r2 * r2 * r2;
  result.by_lens.row(1) << 0, bent_y, 0, 1, lens[1] * y * r2, lens[1] * y * r2 * r2, lens[1] * (r2 + 2 * y * y),
      lens[1] * 2 * x * y, lens[1] * y * r2 * r2 * r2;

  Eigen::Matrix2d bend;
  bend << stretch + 2 * x * x * steep + 2 * p1 * y + 6 * p2 * x, 2 * x * y * steep + 2 * p1 * x + 2 * p2 * y,
      2 * x * y * steep + 2 * p1 * x + 2 * p2 * y, stretch + 2 * y * y * steep + 6 * p1 * y + 2 * p2 * x;
  Eigen::Matrix<double, 2, 3> by_point;
  by_point << 1 / z, 0, -x / z, 0, 1 / z, -y / z;
  by_point = (lens.head<2>().asDiagonal() * bend * by_point).eval();
  Eigen::Matrix3d by_turn;  // d(w x p) / dw
  by_turn << 0, z, -p_camera.y(), -z, 0, p_camera.x(), p_camera.y(), -p_camera.x(), 0;
  result.by_pose << by_point, by_point * by_turn;
  return result;
}

Eigen::Vector2d straighten(const LensVector& lens, const Eigen::Vector2d& pixel) {
  constexpr int kSteps = 20;
  const Eigen::Vector2d seen((pixel.x() - lens[2]) / lens[0], (pixel.y() - lens[3]) / lens[1]);
  Eigen::Vector2d ideal = seen;
  for (int step = 0; step < kSteps; ++step) {
    const Eigen::Vector2d shown = project(lens, ideal.homogeneous()).pixel;
    ideal += Eigen::Vector2d((pixel.x() - shown.x()) / lens[0], (pixel.y() - shown.y()) / lens[1]);
  }
  return ideal;
}

}  // namespace scanknit
