#include "finish/mesh_steps.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "core/rotation.h"

namespace scanknit {

Pose turn_up(const Eigen::Vector3d& up, const Eigen::Vector3d& wanted_up) {
  Pose T = Pose::Identity();
  T.linear() = rotation_between(up, wanted_up).normalized().toRotationMatrix();
  return T;
}

Pose stand_on_origin(const Mesh& mesh, const Eigen::Vector3d& up) {
  Pose T = Pose::Identity();
  if (mesh.positions_m.empty()) return T;
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3f& p : mesh.positions_m) box.extend(p.cast<double>());
  Eigen::Vector3d foot = box.center();
  foot += (std::min(up.dot(box.min()), up.dot(box.max())) - up.dot(foot)) * up;
  T.translation() = -foot;
  return T;
}

void transform_mesh(const Pose& T, Mesh& mesh) {
  for (Eigen::Vector3f& p : mesh.positions_m) p = (T * p.cast<double>()).cast<float>();
  for (Eigen::Vector3f& n : mesh.normals) n = (T.linear() * n.cast<double>()).cast<float>();
}

}  // namespace scanknit
