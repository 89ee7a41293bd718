#include "export/trajectory.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <iterator>

namespace scanknit {

std::string to_tum_trajectory(const std::vector<StampedPose>& poses) {
  std::string text;
  for (const StampedPose& pose : poses) {
    const Eigen::Vector3d t = pose.T_world_camera.translation();
    Eigen::Quaterniond q(pose.T_world_camera.linear());
    q.normalize();
    if (q.w() < 0) q.coeffs() = -q.coeffs();  // q and -q are one rotation: print the one with qw >= 0
    // "{}" prints the fewest digits that give the same double back.
    fmt::format_to(std::back_inserter(text), "{} {} {} {} {} {} {} {}\n", pose.stamp, t.x(), t.y(), t.z(), q.x(), q.y(),
                   q.z(), q.w());
  }
  return text;
}

}  // namespace scanknit
