#include "acquire/lidar/undo_motion.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

namespace scanknit {
namespace {

constexpr std::int64_t kKnot_ns = 1'000'000;              // within a millisecond the motion is a straight line
constexpr std::int64_t kLongestSweep_ns = 2'000'000'000;  // the slowest scanners turn once a second
constexpr double kFarthest_m = 1e4;                       // no scanner goes farther within a sweep
constexpr std::int64_t kLatest_ns = std::numeric_limits<std::int64_t>::max() - 2 * kLongestSweep_ns;

}  // namespace

bool undo_motion(const SensorPath& path, Sweep& sweep) {
  if (!sweep.timestamp_ns || sweep.offsets_ns.empty()) return true;
  if (sweep.offsets_ns.size() != sweep.points_m.size()) return false;
  const auto [first, last] = std::minmax_element(sweep.offsets_ns.begin(), sweep.offsets_ns.end());
  if (*first < -kLongestSweep_ns || *last > kLongestSweep_ns) return false;
  if (*sweep.timestamp_ns < 0 || *sweep.timestamp_ns > kLatest_ns) return false;
  const std::int64_t start = *first, length = *last - start;
  const std::int64_t pieces = length / kKnot_ns + 1;
  const Pose T_sensor_world = sweep.T_world_sensor.inverse();
  std::vector<Eigen::Affine3f> knots;  // from the sensor then to the sensor at the sweep's time
  for (std::int64_t piece = 0; piece <= pieces; ++piece) {
    const auto T_world_sensor = path(*sweep.timestamp_ns + start + length * piece / pieces);
    if (!T_world_sensor) return false;
    const Pose T_sensor_then = T_sensor_world * *T_world_sensor;
    if (!(T_sensor_then.translation().norm() < kFarthest_m)) return false;  // NaN, too
    knots.emplace_back(T_sensor_then.cast<float>());
  }
  const double pieces_per_ns = static_cast<double>(pieces) / static_cast<double>(std::max<std::int64_t>(length, 1));
  for (std::size_t i = 0; i < sweep.points_m.size(); ++i) {
    const double place = static_cast<double>(sweep.offsets_ns[i] - start) * pieces_per_ns;
    const auto knot = std::min(static_cast<std::size_t>(place), static_cast<std::size_t>(pieces - 1));
    const auto fraction = static_cast<float>(place - static_cast<double>(knot));
    const Eigen::Vector3f point = sweep.points_m[i];
    sweep.points_m[i] = (1 - fraction) * (knots[knot] * point) + fraction * (knots[knot + 1] * point);
  }
  sweep.offsets_ns.clear();
  return true;
}

}  // namespace scanknit
