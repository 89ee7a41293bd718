#include "acquire/lidar/cloud_sweep.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "acquire/lidar/lidar_return.h"
#include "acquire/ros2/cloud_message.h"
#include "acquire/ros2/ros2_cloud.h"

namespace scanknit {
namespace {

/// Velodyne's driver writes "time", Ouster's "t", Hesai's, RoboSense's and Livox's "timestamp".
constexpr std::array kTimeNames = {"t", "time", "timestamp", "time_stamp", "offset_time"};

constexpr double kSecond_ns = 1e9;
constexpr double kLongestSweep_ns = 2e9;   // the slowest scanners turn once a second
constexpr double kShortestSweep_ns = 1e6;  // shorter: the numbers are no nanoseconds

struct SweepFields {
  const CloudField *x = nullptr, *y = nullptr, *z = nullptr;
  const CloudField *ring = nullptr, *time = nullptr;  ///< null: there is none
};

const CloudField* find_time(const CloudMessage& cloud) {
  for (const char* name : kTimeNames) {
    const CloudField* field = cloud.find(name, {CloudType::kUint32, CloudType::kFloat32, CloudType::kFloat64});
    if (field != nullptr) return field;
  }
  return nullptr;
}

Result<SweepFields> find_fields(const CloudMessage& cloud) {
  const auto types = {CloudType::kFloat32, CloudType::kFloat64};
  const SweepFields fields{cloud.find("x", types), cloud.find("y", types), cloud.find("z", types), find_ring(cloud),
                           find_time(cloud)};
  if (fields.x == nullptr || fields.y == nullptr || fields.z == nullptr) {
    return Error{ErrorCode::kInput, "a cloud without x, y and z as floating point"};
  }
  return fields;
}

Result<void> check_size(const CloudMessage& cloud, const Limits& limits) {
  if (!cloud.has_all_points()) return Error{ErrorCode::kInput, "the cloud contradicts itself about its size"};
  // Both are below 2^32, so their product fits.
  const std::uint64_t points = std::uint64_t{cloud.width} * cloud.height;
  if (points <= static_cast<std::uint64_t>(limits.max_image_pixels)) return {};
  return Error{ErrorCode::kInput, "a cloud of " + std::to_string(points) + " points is not read"};
}

struct NumberRange {
  double low = 0, high = 0;
};

/// The smallest and the largest of the numbers; not finite where one is not.
NumberRange range_of(const std::vector<double>& numbers) {
  NumberRange range{numbers.front(), numbers.front()};
  for (const double number : numbers) {
    if (!std::isfinite(number)) return {number, number};
    range.low = std::min(range.low, number);
    range.high = std::max(range.high, number);
  }
  return range;
}

/// Nanoseconds after the stamp are `scale` * (number - origin).
struct TimeUnit {
  double scale = 1;
  double origin = 0;

  [[nodiscard]] double length_ns(const NumberRange& range) const { return scale * (range.high - range.low); }
  [[nodiscard]] double farthest_ns(const NumberRange& range) const {
    return scale * std::max(std::abs(range.low - origin), std::abs(range.high - origin));
  }
};

/// Offsets of each number from the stamp; empty: it is not known what they are.
std::vector<std::int64_t> offsets_of(const std::vector<double>& numbers, CloudType type, std::int64_t stamp_ns) {
  const NumberRange range = range_of(numbers);
  if (!std::isfinite(range.low) || !std::isfinite(range.high)) return {};
  const auto stamp = static_cast<double>(stamp_ns);
  std::vector<TimeUnit> units;
  if (type != CloudType::kUint32) units.push_back({kSecond_ns, 0});
  units.push_back({1, 0});
  if (type == CloudType::kFloat64) {
    units.push_back({kSecond_ns, stamp / kSecond_ns});
    units.push_back({1, stamp});
  }
  std::erase_if(units, [&](const TimeUnit& unit) {
    return unit.farthest_ns(range) > kLongestSweep_ns || unit.length_ns(range) < kShortestSweep_ns;
  });
  if (units.empty()) return {};
  const TimeUnit unit = *std::min_element(units.begin(), units.end(), [&](const TimeUnit& a, const TimeUnit& b) {
    return a.farthest_ns(range) < b.farthest_ns(range);
  });
  std::vector<std::int64_t> offsets;
  offsets.reserve(numbers.size());
  for (const double number : numbers) offsets.push_back(std::llround(unit.scale * (number - unit.origin)));
  return offsets;
}

}  // namespace

Result<Sweep> decode_cloud_sweep(const RosMessage& message, std::int64_t stamp_ns, const Limits& limits) {
  const auto cloud = parse_cloud_message(message);
  if (!cloud) return cloud.error();
  const auto fields = find_fields(*cloud);
  if (!fields) return fields.error();
  if (const auto sized = check_size(*cloud, limits); !sized) return sized.error();
  Sweep sweep{.timestamp_ns = stamp_ns};
  std::vector<double> times;
  bool are_rings_sound = fields->ring != nullptr;
  cloud->visit_points([&](std::size_t point) {
    const Eigen::Vector3d p(cloud->number(*fields->x, point), cloud->number(*fields->y, point),
                            cloud->number(*fields->z, point));
    if (!is_lidar_return(p)) return;
    sweep.points_m.emplace_back(p.cast<float>());
    if (fields->time != nullptr) times.push_back(cloud->number(*fields->time, point));
    if (!are_rings_sound) return;
    const double ring = cloud->number(*fields->ring, point);
    are_rings_sound = ring <= std::numeric_limits<std::uint16_t>::max();
    if (are_rings_sound) sweep.rings.push_back(static_cast<std::uint16_t>(ring));
  });
  if (!are_rings_sound) sweep.rings.clear();
  if (!times.empty()) sweep.offsets_ns = offsets_of(times, fields->time->type, stamp_ns);
  return sweep;
}

}  // namespace scanknit
