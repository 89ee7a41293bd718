#include "fusion/turntable_prior.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "core/disjoint_sets.h"
#include "core/median.h"

namespace scanknit {
namespace {

constexpr double kFullTurn = 2 * std::numbers::pi;
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
    offsets.push_back(std::remainder(seen.angles_rad[i] - known_rad[i] - first, kFullTurn));
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
  std::vector<double> steps;
  for (std::size_t i = 1; i < angles.size(); ++i) steps.push_back(angles[i] - angles[i - 1]);
  const double onwards = median(steps) < 0 ? -1 : 1;
  std::vector<std::size_t> jumps;  // the frames after them
  for (std::size_t i = 1; i < angles.size(); ++i) {
    if (is_tracked[i - 1] != is_tracked[i] && onwards * steps[i - 1] < -kBackwards_rad) jumps.push_back(i);
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
  const std::vector<Frames> joined = joined_frames(parts);
  std::vector<double> offs;
  for (const Frames& frames : joined) {
    const double offset = offset_of(frames, known_rad, seen);
    for (const std::size_t i : frames) {
      const double apart = seen.angles_rad[i] - known_rad[i] - offset;
      const double off = std::remainder(apart, kFullTurn);
      offs.push_back(std::abs(off));
      check.agreed_angles_rad[i] += apart - off;
      if (std::abs(off) <= tolerance_rad) continue;
      check.off.push_back(i);
      check.agreed_angles_rad[i] += off;
    }
  }
  check.typical_off_rad = median(offs);
  check.scale = scale_of(joined, known_rad, seen);
  check.contradicts = static_cast<double>(check.off.size()) > kMostOff * static_cast<double>(offs.size());
  return check;
}

}  // namespace scanknit
