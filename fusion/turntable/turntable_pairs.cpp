#include "fusion/turntable/turntable_pairs.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/check.h"
#include "core/rotation.h"
#include "fusion/register/icp.h"

namespace scanknit {
namespace {

constexpr double kSpacing_rad = 5 * kDegree;
constexpr double kMostKeys = 100;
constexpr std::size_t kNeighbours = 3;       // key frames that a new one is registered with
constexpr double kDrift_rad = 24 * kDegree;  // that tracking may have gathered in a turn
constexpr double kTrial_rad = 8 * kDegree;   // registration finds the right angle from within half of this
constexpr std::size_t kLoopsPerKey = 4;

// A pair that does not agree as well as this says nothing.
constexpr double kLeastOverlap = 0.15;
constexpr double kLeastInliers = 0.6;
constexpr double kMostContradicted = 0.15;
constexpr double kLeastColour = 0.35;
constexpr std::size_t kFewestInliers = 200;

double spacing_of(const TurntableMotion& motion) {
  const auto [least, most] = std::minmax_element(motion.angles_rad.begin(), motion.angles_rad.end());
  return std::max(kSpacing_rad, (*most - *least) / kMostKeys);
}

bool is_believable(const IcpResult& fit) {
  return fit.overlap >= kLeastOverlap && fit.inlier_share >= kLeastInliers &&
         fit.contradicted_share <= kMostContradicted && fit.colour_agreement >= kLeastColour &&
         fit.inliers() >= kFewestInliers;
}

}  // namespace

TurntablePairs::TurntablePairs(const TurntableMotion& start, const NoiseModel& noise)
    : start_(start), noise_(noise), spacing_rad_(spacing_of(start)), usual_step_rad_(usual_step_rad(start)) {}

/// From where `to` is registered with a frame shortly before it: where tracking has it, and, if that is somewhere else
/// altogether, the usual steps on.
std::vector<double> TurntablePairs::nearby_angles(const View& from, const View& to) const {
  const double tracked = angle_between(from, to);
  const double usual = usual_step_rad_ * (static_cast<double>(to.frame) - static_cast<double>(from.frame));
  return std::abs(tracked - usual) > kTrial_rad ? std::vector{tracked, usual} : std::vector{tracked};
}

double TurntablePairs::angle_between(const View& from, const View& to) const {
  return start_.angles_rad[to.frame] - start_.angles_rad[from.frame];
}

/// Registers `to` with `from` from the best of some angles.
bool TurntablePairs::join(const View& from, const View& to, const std::vector<double>& angles_rad,
                          const TurntableAxis& axis, int first_level) {
  IcpConfig coarse{noise_};
  coarse.first_level = coarse.last_level = first_level;
  IcpResult best;
  best.support = -1;
  for (const double angle : angles_rad) {
    const IcpResult tried = register_frame(to.seen, from.seen, turn_about(axis, angle), coarse);
    if (tried.support > best.support) best = tried;
  }
  IcpConfig fine{noise_};
  fine.first_level = first_level - 1;
  const IcpResult found = register_frame(to.seen, from.seen, best.T_model_frame, fine);
  if (!is_believable(found)) return false;
  edges_.push_back({from.frame, to.frame, found.T_model_frame, found.information, found.centre});
  return true;
}

void TurntablePairs::join_pending() {
  for (const View& view : pending_) {
    const std::size_t nearest = std::min<std::size_t>(keys_.size(), 2);
    for (std::size_t k = keys_.size() - nearest; k < keys_.size(); ++k) {
      join(keys_[k], view, nearby_angles(keys_[k], view), start_.axis, 1);
    }
  }
  pending_.clear();
}

void TurntablePairs::add(std::size_t frame, SurfacePyramid seen) {
  SCANKNIT_CHECK(frame < start_.angles_rad.size());
  View view{frame, std::move(seen)};
  if (!keys_.empty() && std::abs(angle_between(keys_.back(), view)) < spacing_rad_) {
    pending_.push_back(std::move(view));
    return;
  }
  const std::size_t first = keys_.size() - std::min(keys_.size(), kNeighbours);
  for (std::size_t k = first; k < keys_.size(); ++k) {
    const bool fits = join(keys_[k], view, nearby_angles(keys_[k], view), start_.axis, 2);
    if (k + 1 == keys_.size()) in_sequence_ += fits;
  }
  keys_.push_back(std::move(view));
  join_pending();
}

void TurntablePairs::close() {
  join_pending();
  const double near_rad = 2 * spacing_rad_ + kDrift_rad;
  for (std::size_t j = 0; j < keys_.size(); ++j) {
    std::vector<std::pair<double, std::size_t>> places;  // how far off, which key frame
    for (std::size_t i = 0; i + kNeighbours < j; ++i) {
      const double apart = angle_between(keys_[i], keys_[j]);
      if (std::abs(apart) < kFullTurn / 2) continue;  // not round yet
      const double off = std::abs(wrapped(apart));
      if (off < near_rad) places.emplace_back(off, i);
    }
    std::sort(places.begin(), places.end());
    if (places.size() > kLoopsPerKey) places.resize(kLoopsPerKey);
    for (const auto& [off, i] : places) {
      const double apart = wrapped(angle_between(keys_[i], keys_[j]));
      std::vector<double> trials;
      for (double aside = -kDrift_rad; aside <= kDrift_rad; aside += kTrial_rad) trials.push_back(apart + aside);
      loops_ += join(keys_[i], keys_[j], trials, start_.axis, 2);
    }
  }
}

void TurntablePairs::remove(const std::vector<bool>& is_removed) {
  SCANKNIT_CHECK(is_removed.size() == edges_.size());
  std::size_t kept = 0;
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    if (!is_removed[i]) edges_[kept++] = edges_[i];
  }
  edges_.resize(kept);
}

double TurntablePairs::share_in_sequence() const {
  return keys_.size() < 2 ? 1 : static_cast<double>(in_sequence_) / static_cast<double>(keys_.size() - 1);
}

void TurntablePairs::join_across(const TurntableMotion& motion, const std::vector<std::size_t>& parts) {
  constexpr std::size_t kEvery = 2;
  for (std::size_t j = 0; j < keys_.size(); j += kEvery) {
    for (int eighths = 1; eighths <= 4; ++eighths) {
      const double wanted = kFullTurn * eighths / 8;
      for (std::size_t i = 0; i < j; ++i) {
        const double apart = motion.angles_rad[keys_[j].frame] - motion.angles_rad[keys_[i].frame];
        if (parts[keys_[i].frame] != parts[keys_[j].frame]) continue;
        if (std::abs(apart - wanted) > spacing_rad_ / 2) continue;
        across_ += join(keys_[i], keys_[j], {apart}, motion.axis, 1);
        break;
      }
    }
  }
}

}  // namespace scanknit
