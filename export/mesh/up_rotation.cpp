#include "export/mesh/up_rotation.h"

#include <Eigen/Geometry>

namespace scanknit {

Eigen::Vector3f direction(UpAxis axis) {
  switch (axis) {
    case UpAxis::kX: return {1, 0, 0};
    case UpAxis::kY: return {0, 1, 0};
    case UpAxis::kZ: return {0, 0, 1};
    case UpAxis::kMinusX: return {-1, 0, 0};
    case UpAxis::kMinusY: return {0, -1, 0};
    case UpAxis::kMinusZ: return {0, 0, -1};
  }
  return {0, 0, 1};
}

Eigen::Matrix3f up_rotation(UpAxis from, UpAxis to) {
  const Eigen::Vector3f a = direction(from);
  const Eigen::Vector3f b = direction(to);
  if (a == b) return Eigen::Matrix3f::Identity();
  if (a == -b) {
    const Eigen::Vector3f diagonal = a.x() != 0 ? Eigen::Vector3f(-1, 1, -1) : Eigen::Vector3f(1, -1, -1);
    return diagonal.asDiagonal();
  }
  // The quarter turn about n = a x b sends a to b, b to -a and keeps n.
  const Eigen::Vector3f n = a.cross(b);
  return b * a.transpose() - a * b.transpose() + n * n.transpose();
}

const char* to_string(UpAxis axis) {
  switch (axis) {
    case UpAxis::kX: return "X";
    case UpAxis::kY: return "Y";
    case UpAxis::kZ: return "Z";
    case UpAxis::kMinusX: return "-X";
    case UpAxis::kMinusY: return "-Y";
    case UpAxis::kMinusZ: return "-Z";
  }
  return "Z";
}

}  // namespace scanknit
