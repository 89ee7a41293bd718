#include "tests/app/trajectory_error.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <sstream>
#include <string>

namespace scanknit {
namespace {

using Track = std::map<double, Eigen::Vector3d>;

Track read_track(const std::filesystem::path& path) {
  Track track;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream numbers(line);
    double stamp = 0;
    Eigen::Vector3d position;
    if (numbers >> stamp >> position.x() >> position.y() >> position.z()) track[stamp] = position;
  }
  return track;
}

std::optional<Eigen::Vector3d> nearest(const Track& track, double stamp) {
  auto after = track.lower_bound(stamp);
  if (after != track.begin() && (after == track.end() || after->first - stamp > stamp - std::prev(after)->first)) {
    --after;
  }
  if (after == track.end() || std::abs(after->first - stamp) > kSameStamp_s) return std::nullopt;
  return after->second;
}

}  // namespace

TrajectoryError trajectory_error(const std::filesystem::path& estimate_file, const std::filesystem::path& truth_file) {
  const Track estimate = read_track(estimate_file);
  const Track truth = read_track(truth_file);
  TrajectoryError error;
  error.estimated = estimate.size();
  Eigen::Matrix3Xd from(3, estimate.size());
  Eigen::Matrix3Xd to(3, estimate.size());
  for (const auto& [stamp, position] : estimate) {
    const auto true_position = nearest(truth, stamp);
    if (!true_position) continue;
    from.col(static_cast<Eigen::Index>(error.pairs)) = position;
    to.col(static_cast<Eigen::Index>(error.pairs)) = *true_position;
    ++error.pairs;
  }
  if (error.pairs == 0) return error;
  from.conservativeResize(3, static_cast<Eigen::Index>(error.pairs));
  to.conservativeResize(3, static_cast<Eigen::Index>(error.pairs));
  const auto rmse = [&](const Eigen::Matrix3Xd& difference) {
    return std::sqrt(difference.colwise().squaredNorm().mean());
  };
  error.unaligned_rmse_m = rmse(from - to);
  const Eigen::Affine3d T_to_from(Eigen::umeyama(from, to, /*with_scaling=*/false));
  const Eigen::Matrix3Xd rest = (T_to_from * from) - to;
  error.rmse_m = rmse(rest);
  error.max_m = rest.colwise().norm().maxCoeff();
  return error;
}

}  // namespace scanknit
