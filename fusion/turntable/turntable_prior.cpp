#include "fusion/turntable/turntable_prior.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>

#include "core/median.h"
#include "core/mesh/disjoint_sets.h"

namespace scanknit {
namespace {

constexpr double kMostOff = 0.2;  // of the frames, for the others to be right

using Frames = std::vector<std::size_t>;

/// The frames of each part of two or more.
std::vector<Frames> joined_frames(const std::vector<std::size_t>& parts) {
  std::map<std::size_t, Frames> by_part;
  for (std::size_t i = 0; i < parts.size(); ++i) by_part[parts[i]].push_back(i);
  std::vector<Frames> joined;
  for (auto& [part, frames] : by_part) {
    if (frames.size() > 1) joined.push_back(std::move(frames));
  }
  return joined;
}

/// What is to be added to the known angles of a part.
double offset_of(const Frames& frames, const std::vector<double>& known_rad, const TurntableMotion& seen) {
  const double first = seen.angles_rad[frames.front()] - known_rad[frames.front()];
  std::vector<double> offsets;
  for (const std::size_t i : frames) {
    offsets.push_back(wrapped(seen.angles_rad[i] - known_rad[i] - first));
  }
  return first + median(offsets);
}

/// Of the pictures' turn by the known one.
double scale_of(const std::vector<Frames>& joined, const std::vector<double>& known_rad, const TurntableMotion& seen) {
  double both = 0, known = 0;
  for (const Frames& frames : joined) {
    double mean_known = 0, mean_seen = 0;
    for (const std::size_t i : frames) {
      mean_known += known_rad[i] / static_cast<double>(frames.size());
      mean_seen += seen.angles_rad[i] / static_cast<double>(frames.size());
    }
    for (const std::size_t i : frames) {
      both += (known_rad[i] - mean_known) * (seen.angles_rad[i] - mean_seen);
      known += (known_rad[i] - mean_known) * (known_rad[i] - mean_known);
    }
  }
  return known > 0 ? both / known : 0;  // 0: it does not turn
}

}  // namespace

std::vector<double> angles_of_all(const std::vector<std::uint64_t>& sequences,
                                  const std::vector<std::uint64_t>& tracked, const std::vector<double>& tracked_rad) {
  const auto per_frame = [&](std::size_t i) {  // from the tracked frame i - 1 to i
    return (tracked_rad[i] - tracked_rad[i - 1]) / static_cast<double>(tracked[i] - tracked[i - 1]);
  };
  std::vector<double> steps;
  for (std::size_t i = 1; i < tracked.size(); ++i) steps.push_back(per_frame(i));
  const double usual = median(steps);
  std::vector<double> angles;
  for (const std::uint64_t sequence : sequences) {
    const auto next =
        static_cast<std::size_t>(std::lower_bound(tracked.begin(), tracked.end(), sequence) - tracked.begin());
    if (next == 0) {
      angles.push_back(tracked_rad[0] - usual * static_cast<double>(tracked[0] - sequence));
    } else if (next < tracked.size() && tracked[next] == sequence) {
      angles.push_back(tracked_rad[next]);
    } else {
      const bool is_usual = next < tracked.size() && std::abs(per_frame(next) - usual) <= std::abs(usual) / 2;
      const double step = is_usual ? per_frame(next) : usual;
      angles.push_back(tracked_rad[next - 1] + step * static_cast<double>(sequence - tracked[next - 1]));
    }
  }
  return angles;
}

TurntableMotion along_pairs(const TurntableMotion& start, const std::vector<TurntableEdge>& edges) {
  const std::size_t frames = start.angles_rad.size();
  std::vector<std::size_t> order(edges.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto apart = [&](std::size_t i) {
    return std::max(edges[i].from, edges[i].to) - std::min(edges[i].from, edges[i].to);
  };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return apart(a) < apart(b); });
  DisjointSets joined(frames);
  std::vector<std::vector<std::pair<std::size_t, double>>> next(frames);  // frame, and by how much it has turned
  for (const std::size_t i : order) {
    const auto a = static_cast<std::uint32_t>(edges[i].from), b = static_cast<std::uint32_t>(edges[i].to);
    if (joined.root(a) == joined.root(b)) continue;
    joined.join(a, b);
    const double turned = wrapped(angle_about(start.axis.direction, edges[i].T_from_to.linear()));
    next[a].emplace_back(b, turned);
    next[b].emplace_back(a, -turned);
  }
  TurntableMotion motion = start;
  std::vector<bool> is_reached(frames);
  for (std::size_t first = 0; first < frames; ++first) {
    if (is_reached[first]) continue;
    Frames part = {first};
    is_reached[first] = true;
    std::vector<double> offsets;
    for (std::size_t k = 0; k < part.size(); ++k) {
      const std::size_t here = part[k];
      offsets.push_back(start.angles_rad[here] - motion.angles_rad[here]);
      for (const auto& [there, turned] : next[here]) {
        if (is_reached[there]) continue;
        is_reached[there] = true;
        motion.angles_rad[there] = motion.angles_rad[here] + turned;
        part.push_back(there);
      }
    }
    const double offset = median(offsets);
    for (const std::size_t frame : part) motion.angles_rad[frame] += offset;
  }
  const double first = motion.angles_rad.empty() ? 0 : motion.angles_rad.front();
  for (double& angle : motion.angles_rad) angle -= first;
  return motion;
}

std::vector<std::size_t> turntable_parts(const TurntableSolution& solution, const std::vector<TurntableEdge>& edges,
                                         double least_weight) {
  const std::size_t frames = solution.motion.angles_rad.size();
  DisjointSets joined(frames);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (solution.weights[i] <= least_weight) continue;
    joined.join(static_cast<std::uint32_t>(edges[i].from), static_cast<std::uint32_t>(edges[i].to));
  }
  std::vector<std::size_t> roots;
  for (std::size_t i = 0; i < frames; ++i) roots.push_back(joined.root(static_cast<std::uint32_t>(i)));
  std::vector<std::size_t> sizes(frames);
  for (std::size_t i = 0; i < frames; ++i) ++sizes[roots[i]];
  const auto largest = static_cast<std::size_t>(std::max_element(sizes.begin(), sizes.end()) - sizes.begin());
  std::vector<std::size_t> numbers(frames);  // of the parts, by their first frame
  std::size_t next = 1;
  for (std::size_t i = 0; i < frames; ++i) {
    if (sizes[i] > 0) numbers[i] = i == largest ? 0 : next++;
  }
  std::vector<std::size_t> parts(frames);
  for (std::size_t i = 0; i < frames; ++i) parts[i] = numbers[roots[i]];
  return parts;
}

std::vector<bool> backward_jumps(const TurntableMotion& motion, const std::vector<TurntableEdge>& edges,
                                 const std::vector<bool>& is_tracked) {
  constexpr double kBackwards_rad = std::numbers::pi / 180;
  const auto& angles = motion.angles_rad;
  const double onwards = usual_step_rad(motion) < 0 ? -1 : 1;
  std::vector<std::size_t> jumps;  // the frames after them
  for (std::size_t i = 1; i < angles.size(); ++i) {
    const double step_rad = angles[i] - angles[i - 1];
    if (is_tracked[i - 1] != is_tracked[i] && onwards * step_rad < -kBackwards_rad) jumps.push_back(i);
  }
  std::vector<bool> doubtful;
  for (const TurntableEdge& edge : edges) {
    const auto [first, last] = std::minmax(edge.from, edge.to);
    doubtful.push_back(std::any_of(jumps.begin(), jumps.end(),
                                   [first = first, last = last](std::size_t j) { return first < j && j <= last; }));
  }
  return doubtful;
}

PriorCheck check_prior(const std::vector<double>& known_rad, const TurntableMotion& seen,
                       const std::vector<std::size_t>& parts, double tolerance_rad) {
  PriorCheck check;
  check.agreed_angles_rad = known_rad;
  std::vector<Frames> joined = joined_frames(parts);
  std::vector<double> offs;
  double widest_rad = 0;
  for (const Frames& frames : joined) {
    widest_rad = std::max(widest_rad, std::abs(seen.angles_rad[frames.back()] - seen.angles_rad[frames.front()]));
    const double offset = offset_of(frames, known_rad, seen);
    for (const std::size_t i : frames) {
      const double apart = seen.angles_rad[i] - known_rad[i] - offset;
      const double off = wrapped(apart);
      offs.push_back(std::abs(off));
      check.agreed_angles_rad[i] += apart - off;
      if (std::abs(off) <= tolerance_rad) continue;
      check.off.push_back(i);
      check.agreed_angles_rad[i] += off;
    }
  }
  std::sort(check.off.begin(), check.off.end());
  check.typical_off_rad = median(offs);
  check.contradicts = static_cast<double>(check.off.size()) > kMostOff * static_cast<double>(offs.size());
  if (check.contradicts) {
    check.scale = scale_of(joined, known_rad, seen);
    return check;
  }
  for (Frames& frames : joined) {
    std::erase_if(frames, [&](std::size_t i) { return std::binary_search(check.off.begin(), check.off.end(), i); });
  }
  check.scale = scale_of(joined, check.agreed_angles_rad, seen);
  check.contradicts = std::abs(check.scale - 1) * widest_rad > tolerance_rad;
  return check;
}

}  // namespace scanknit
