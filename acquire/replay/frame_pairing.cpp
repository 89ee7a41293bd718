#include "acquire/replay/frame_pairing.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace scanknit {
namespace {

constexpr double kUsualRate = 30;       // frames a second, where the profile does not say
constexpr std::size_t kMaxWaiting = 3;  // a tenth of a second at that rate
constexpr std::size_t kMaxColour = 16;  // more than may lie between two depth pictures

// Stamps may be anything, so that the difference of two may not fit 64 bits.
std::uint64_t distance_ns(std::int64_t a, std::int64_t b) {
  return a > b ? static_cast<std::uint64_t>(a) - static_cast<std::uint64_t>(b)
               : static_cast<std::uint64_t>(b) - static_cast<std::uint64_t>(a);
}

}  // namespace

std::int64_t pairing_reach_ns(const StreamProfile& colour) {
  const bool is_known = colour.frames_per_second >= 0.01 && colour.frames_per_second <= 1e6;
  return static_cast<std::int64_t>(0.5e9 / (is_known ? colour.frames_per_second : kUsualRate));
}

std::optional<std::size_t> nearest_in_time(std::span<const std::int64_t> times_ns, std::int64_t time_ns,
                                           std::int64_t reach_ns) {
  if (times_ns.empty()) return std::nullopt;
  auto best = std::lower_bound(times_ns.begin(), times_ns.end(), time_ns);
  const bool is_after_all = best == times_ns.end();
  if (best != times_ns.begin() &&
      (is_after_all || distance_ns(*std::prev(best), time_ns) <= distance_ns(*best, time_ns))) {
    --best;
  }
  if (distance_ns(*best, time_ns) > static_cast<std::uint64_t>(reach_ns)) return std::nullopt;
  return static_cast<std::size_t>(best - times_ns.begin());
}

std::vector<std::optional<std::size_t>> pair_by_time(std::span<const std::int64_t> depth_ns,
                                                     std::span<const std::int64_t> colour_ns, std::int64_t reach_ns) {
  std::vector<std::size_t> order(colour_ns.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return colour_ns[a] < colour_ns[b]; });
  std::vector<std::int64_t> sorted_ns;
  for (const std::size_t i : order) sorted_ns.push_back(colour_ns[i]);
  std::vector<std::optional<std::size_t>> partners;
  for (const std::int64_t time_ns : depth_ns) {
    const auto place = nearest_in_time(sorted_ns, time_ns, reach_ns);
    partners.push_back(place ? std::optional(order[*place]) : std::nullopt);
  }
  return partners;
}

void FramePairing::add(RawFrame frame) {
  if (frame.profile.kind == StreamKind::kDepth) {
    depth_.push_back(std::move(frame));
    return;
  }
  if (!colour_.empty() && frame.device_ns <= colour_.back().device_ns) return;
  colour_.push_back(std::move(frame));
  if (colour_.size() > kMaxColour) colour_.pop_front();
}

std::optional<RawPair> FramePairing::next() {
  if (depth_.empty()) return std::nullopt;
  const bool has_later_colour = !colour_.empty() && colour_.back().device_ns >= depth_.front().device_ns;
  if (has_colour_ && !has_later_colour && depth_.size() < kMaxWaiting) return std::nullopt;
  return pair_first();
}

std::optional<RawPair> FramePairing::next_at_end() {
  return depth_.empty() ? std::nullopt : pair_first();
}

std::optional<RawPair> FramePairing::pair_first() {
  RawPair pair{std::move(depth_.front()), std::nullopt};
  depth_.pop_front();
  std::vector<std::int64_t> times_ns;
  for (const RawFrame& frame : colour_) times_ns.push_back(frame.device_ns);
  const std::int64_t reach_ns = colour_.empty() ? 0 : pairing_reach_ns(colour_.front().profile);
  const auto nearest = nearest_in_time(times_ns, pair.depth.device_ns, reach_ns);
  if (!nearest) return pair;
  pair.colour = colour_[*nearest];
  // Depth pictures come later and later: what lies before this colour picture is nearest to none of them.
  colour_.erase(colour_.begin(), colour_.begin() + static_cast<std::ptrdiff_t>(*nearest));
  return pair;
}

}  // namespace scanknit
