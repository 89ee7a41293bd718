#include "export/trajectory.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <iterator>
#include <nlohmann/json.hpp>

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

std::string to_kitti_trajectory(const std::vector<StampedPose>& poses) {
  std::string text;
  for (const StampedPose& pose : poses) {
    for (int i = 0; i < 12; ++i) {
      fmt::format_to(std::back_inserter(text), "{}{}", pose.T_world_camera(i / 4, i % 4), i < 11 ? ' ' : '\n');
    }
  }
  return text;
}

std::string to_json_trajectory(const std::vector<StampedPose>& poses, std::string_view note) {
  nlohmann::ordered_json json;
  if (!note.empty()) json["note"] = note;
  json["poses"] = nlohmann::ordered_json::array();
  for (const StampedPose& pose : poses) {
    auto rows = nlohmann::ordered_json::array();
    for (int row = 0; row < 4; ++row) {
      const auto& T = pose.T_world_camera;
      rows.push_back({T(row, 0), T(row, 1), T(row, 2), T(row, 3)});
    }
    json["poses"].push_back({{"stamp", pose.stamp}, {"T_world_camera", std::move(rows)}});
  }
  return json.dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

std::string trajectory_text(const std::filesystem::path& path, const std::vector<StampedPose>& poses,
                            std::string_view note) {
  if (path.extension() == ".kitti") return to_kitti_trajectory(poses);
  if (path.extension() == ".json") return to_json_trajectory(poses, note);
  const std::string first = note.empty() ? "" : "# " + std::string(note) + "\n";
  return first + to_tum_trajectory(poses);
}

}  // namespace scanknit
