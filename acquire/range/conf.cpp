#include <Eigen/Geometry>
#include <cmath>

#include "acquire/range/range_files.h"
#include "acquire/replay/text_numbers.h"
#include "core/files/ascii_numbers.h"

namespace scanknit {
namespace {

constexpr double kQuaternionTolerance = 0.01;  // printed with six digits

Error broken(std::size_t line, const std::string& what) {
  return {ErrorCode::kInput, "line " + std::to_string(line) + ": " + what};
}

/// Points are turned by the inverse of the quaternion's rotation.
Result<Pose> transposed_pose(const TextLine& line) {
  std::array<double, 7> v{};
  for (std::size_t i = 0; i < v.size(); ++i) {
    const auto number = parse_double(line.words[i + 2]);
    if (!number || !std::isfinite(*number))
      return broken(line.number, "a number was expected, not '" + std::string(line.words[i + 2]) + "'");
    v[i] = *number;
  }
  const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
  if (!(std::abs(q.norm() - 1) <= kQuaternionTolerance)) {
    return broken(line.number, "the quaternion's length is " + std::to_string(q.norm()) + ", expected 1");
  }
  Pose pose = Pose::Identity();
  pose.linear() = q.normalized().toRotationMatrix().transpose();
  pose.translation() = Eigen::Vector3d(v[0], v[1], v[2]);
  return pose;
}

}  // namespace

Result<std::vector<NamedScan>> parse_conf(std::string_view text, const Limits& limits) {
  std::vector<NamedScan> scans;
  for (const TextLine& line : text_lines(text)) {
    const std::string_view key = line.words[0];
    if (key == "camera" || key == "mesh") continue;  // "mesh": an older form, whose poses are not these
    if (key != "bmesh")
      return broken(line.number, "unknown keyword '" + std::string(key) + "', expected bmesh or camera");
    if (line.words.size() != 9) return broken(line.number, "expected bmesh FILE tx ty tz qx qy qz qw");
    if (scans.size() >= limits.max_scans)
      return broken(line.number, "more scans than the limit of " + std::to_string(limits.max_scans));
    const auto pose = transposed_pose(line);
    if (!pose) return pose.error();
    scans.push_back({std::string(line.words[1]), *pose, line.number});
  }
  if (scans.empty())
    return Error{ErrorCode::kInput, "no scan in it: a line 'bmesh FILE tx ty tz qx qy qz qw' was expected"};
  return scans;
}

}  // namespace scanknit
