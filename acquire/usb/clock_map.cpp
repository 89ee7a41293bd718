#include "acquire/usb/clock_map.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>
#include <vector>

#include "core/check.h"

namespace scanknit {
namespace {

constexpr std::int64_t kNsPerSecond = 1'000'000'000;
constexpr std::size_t kMaxPairs = 512;  // 17 s at 30 frames a second: crystals drift more slowly than that
constexpr double kMaxSkew = 500e-6;     // crystals are better than 100 ppm; more comes of too few pairs
constexpr std::int64_t kMaxStepError = kNsPerSecond / 2;

}  // namespace

void ClockMap::add(std::int64_t device_ns, std::int64_t host_ns) {
  pairs_.push_back({device_ns, host_ns});
  if (pairs_.size() > kMaxPairs) pairs_.pop_front();
}

/// Of all lines below the pairs, the sum of distances is least for the edge of their lower hull that spans their mean.
std::optional<ClockMap::Line> ClockMap::fit() const {
  if (pairs_.empty()) return std::nullopt;
  const Pair origin = pairs_.front();
  struct Point {
    double device, delay;  // since the first pair; the delay grows with the skew only
  };
  std::vector<Point> hull;
  double mean = 0;
  for (const Pair& pair : pairs_) {
    const std::int64_t device = pair.device_ns - origin.device_ns;
    const Point p{static_cast<double>(device), static_cast<double>(pair.host_ns - origin.host_ns - device)};
    mean += p.device / static_cast<double>(pairs_.size());
    const auto is_above_edge = [&] {
      const Point &a = hull[hull.size() - 2], &b = hull.back();
      return (b.delay - a.delay) * (p.device - a.device) >= (p.delay - a.delay) * (b.device - a.device);
    };
    while (hull.size() >= 2 && is_above_edge()) hull.pop_back();
    hull.push_back(p);
  }
  std::size_t edge = 0;
  while (edge + 2 < hull.size() && hull[edge + 1].device < mean) ++edge;
  const auto through = [&origin](const Point& p) {
    const auto device = origin.device_ns + static_cast<std::int64_t>(p.device);
    return Pair{device, origin.host_ns + static_cast<std::int64_t>(p.device) + static_cast<std::int64_t>(p.delay)};
  };
  if (hull.size() >= 2) {
    const double skew = (hull[edge + 1].delay - hull[edge].delay) / (hull[edge + 1].device - hull[edge].device);
    if (std::abs(skew) <= kMaxSkew) return Line{through(hull[edge]), skew};
  }
  const auto least =
      std::min_element(hull.begin(), hull.end(), [](const Point& a, const Point& b) { return a.delay < b.delay; });
  return Line{through(*least), 0.0};
}

std::optional<std::int64_t> ClockMap::host_of(std::int64_t device_ns) const {
  const auto line = fit();
  if (!line) return std::nullopt;
  const std::int64_t since = device_ns - line->through.device_ns;
  return line->through.host_ns + since + std::llround(line->skew * static_cast<double>(since));
}

std::optional<std::int64_t> ClockMap::device_of(std::int64_t host_ns) const {
  const auto line = fit();
  if (!line) return std::nullopt;
  const std::int64_t since = host_ns - line->through.host_ns;
  return line->through.device_ns + since - std::llround(line->skew / (1 + line->skew) * static_cast<double>(since));
}

DeviceClock::DeviceClock(std::uint32_t ticks_per_second) : ticks_per_second_(ticks_per_second) {
  SCANKNIT_CHECK(ticks_per_second >= 1);
}

std::int64_t DeviceClock::in_ns(std::uint64_t ticks) const {
  const std::uint64_t seconds = ticks / ticks_per_second_;
  const std::uint64_t rest = ticks % ticks_per_second_;
  return static_cast<std::int64_t>(seconds * kNsPerSecond + rest * kNsPerSecond / ticks_per_second_);
}

DeviceClock::Stamp DeviceClock::stamp(std::optional<std::uint32_t> ticks, std::int64_t host_ns) {
  const std::int64_t host_step = host_ns - last_host_ns_;
  const bool is_first = std::exchange(is_first_, false);
  last_host_ns_ = host_ns;
  if (!ticks) {
    last_device_ns_ = is_first ? host_ns : std::max(last_device_ns_ + 1, host_ns);
    return {last_device_ns_, false};
  }
  const auto last = std::exchange(last_ticks_, ticks);
  if (!last) {
    ticks_ = *ticks;
    last_device_ns_ = is_first ? in_ns(ticks_) : std::max(last_device_ns_ + 1, in_ns(ticks_));
    offset_ns_ = last_device_ns_ - in_ns(ticks_);
    map_.add(last_device_ns_, host_ns);
    return {last_device_ns_, false};
  }
  std::uint64_t step = static_cast<std::uint32_t>(*ticks - *last);
  // A pause longer than the counter's range: as many whole ranges as this computer's clock says.
  const std::int64_t range_ns = in_ns(std::uint64_t{1} << 32);
  const std::int64_t ranges = (host_step - in_ns(step) + range_ns / 2) / range_ns;
  if (ranges > 0) step += static_cast<std::uint64_t>(ranges) << 32;
  if (step == 0 || std::abs(in_ns(step) - host_step) > kMaxStepError) {
    ticks_ = *ticks;
    return after_jump(host_ns);
  }
  ticks_ += step;
  last_device_ns_ = std::max(last_device_ns_ + 1, in_ns(ticks_) + offset_ns_);
  map_.add(last_device_ns_, host_ns);
  return {last_device_ns_, false};
}

DeviceClock::Stamp DeviceClock::after_jump(std::int64_t host_ns) {
  last_device_ns_ = std::max(last_device_ns_ + 1, map_.device_of(host_ns).value_or(host_ns));
  offset_ns_ = last_device_ns_ - in_ns(ticks_);
  return {last_device_ns_, true};
}

}  // namespace scanknit
