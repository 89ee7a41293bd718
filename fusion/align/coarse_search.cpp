#include "fusion/align/coarse_search.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace scanknit {
namespace {

using Eigen::Matrix3f;
using Eigen::Vector3f;

constexpr std::size_t kAlike = 5;          // features that a point is paired with, each way
constexpr std::size_t kDraws = 1'500'000;  // of two pairs
constexpr std::size_t kDrawsPerTask = 10'000;
constexpr std::size_t kMostTried = 6'000;  // that pass prerejection; fixed, so that time is bounded
constexpr std::size_t kTestPoints = 250;   // a pose is judged by
constexpr std::size_t kKept = 24;          // poses for a closer look
constexpr double kHopeless = 0.08;         // of the points that meet the other scan, by a first look
constexpr float kLengthTolerance = 1.5f;   // spacings
constexpr float kAngleTolerance = 0.2f;    // rad, about, for cosines
constexpr float kLeastBaseline = 6;        // spacings
constexpr float kNear = 1.5f;              // spacings: a point that meets the other scan
constexpr float kSameCoarseTurn = 0.2f;    // rad; and
constexpr float kSameCoarsePlace = 4;      // spacings: two poses that are one

/// SplitMix64 (Steele, Lea & Flood 2014): another number for each counter.
std::uint64_t mixed(std::uint64_t counter) {
  std::uint64_t z = counter * 0x9E3779B97F4A7C15u + 0x9E3779B97F4A7C15u;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}

struct LookAlike {
  std::uint32_t in_a, in_b;
  friend bool operator==(const LookAlike&, const LookAlike&) = default;
  friend auto operator<=>(const LookAlike&, const LookAlike&) = default;
};

std::vector<LookAlike> find_look_alikes(const std::vector<SurfaceFeature>& a, const std::vector<SurfaceFeature>& b) {
  std::vector<LookAlike> pairs;
  const auto of_b = nearest_features(b, a, kAlike);
  for (std::uint32_t i = 0; i < of_b.size(); ++i) {
    for (const std::uint32_t k : of_b[i]) pairs.push_back({k, i});
  }
  const auto of_a = nearest_features(a, b, kAlike);
  for (std::uint32_t i = 0; i < of_a.size(); ++i) {
    for (const std::uint32_t k : of_a[i]) pairs.push_back({i, k});
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

/// Axes that two oriented points span: along their baseline, and the mean normal across it.
std::optional<Matrix3f> axes_of(const Vector3f& baseline, const Vector3f& normals) {
  const Vector3f x = baseline.normalized();
  const Vector3f across = normals - normals.dot(x) * x;
  if (!(across.norm() > 0.3f)) return std::nullopt;
  const Vector3f y = across.normalized();
  Matrix3f axes;
  axes << x, y, x.cross(y);
  return axes;
}

class CoarseSearch {
 public:
  CoarseSearch(const ScanLevel& a, const ScanLevel& b, std::vector<LookAlike> pairs, std::uint64_t seed)
      : a_(a), b_(b), pairs_(std::move(pairs)), seed_(seed), spacing_(static_cast<float>(a.spacing_m)) {}

  [[nodiscard]] std::vector<Pose> best() const {
    std::vector<Candidate> candidates = draw_all();
    tbb::parallel_for(std::size_t{0}, candidates.size(), [&](std::size_t i) { judge(candidates[i]); });
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const Candidate& x, const Candidate& y) { return x.met > y.met; });
    std::vector<Pose> kept;
    for (const Candidate& candidate : candidates) {
      if (kept.size() == kKept || candidate.met == 0) break;
      const Pose pose(candidate.T_a_b.cast<double>());
      if (std::none_of(kept.begin(), kept.end(), [&](const Pose& other) { return is_same(pose, other); })) {
        kept.push_back(pose);
      }
    }
    return kept;
  }

 private:
  struct Candidate {
    Eigen::Isometry3f T_a_b;
    int met = 0;
  };

  [[nodiscard]] std::vector<Candidate> draw_all() const {
    std::vector<Candidate> all;
    if (pairs_.size() < 2) return all;
    constexpr std::size_t kTasks = kDraws / kDrawsPerTask;
    std::vector<std::vector<Candidate>> drawn(kTasks);
    tbb::parallel_for(std::size_t{0}, kTasks, [&](std::size_t task) {
      for (std::size_t i = task * kDrawsPerTask; i < (task + 1) * kDrawsPerTask; ++i) {
        if (const auto pose = draw(i)) drawn[task].push_back({*pose});
      }
    });
    for (const auto& part : drawn) all.insert(all.end(), part.begin(), part.end());
    if (all.size() <= kMostTried) return all;
    std::vector<Candidate> some;  // evenly from all draws
    for (std::size_t i = 0; i < kMostTried; ++i) some.push_back(all[i * all.size() / kMostTried]);
    return some;
  }

  [[nodiscard]] std::optional<Eigen::Isometry3f> draw(std::size_t number) const {
    const std::uint64_t random = mixed(seed_ ^ mixed(number));
    const LookAlike& first = pairs_[(random >> 32) % pairs_.size()];
    const LookAlike& second = pairs_[(random & 0xFFFFFFFFu) % pairs_.size()];
    const Vector3f &a1 = a_.points.points_m[first.in_a], &a2 = a_.points.points_m[second.in_a];
    const Vector3f &b1 = b_.points.points_m[first.in_b], &b2 = b_.points.points_m[second.in_b];
    const Vector3f baseline_a = a2 - a1;
    const Vector3f baseline_b = b2 - b1;
    const float length_a = baseline_a.norm();
    const float length_b = baseline_b.norm();
    if (length_b < kLeastBaseline * spacing_ || std::abs(length_a - length_b) > kLengthTolerance * spacing_) return {};
    const Vector3f &na1 = a_.points.normals[first.in_a], &na2 = a_.points.normals[second.in_a];
    const Vector3f &nb1 = b_.points.normals[first.in_b], &nb2 = b_.points.normals[second.in_b];
    const auto differs = [](float x, float y) { return std::abs(x - y) > kAngleTolerance; };
    if (differs(na1.dot(na2), nb1.dot(nb2)) ||
        differs(na1.dot(baseline_a) / length_a, nb1.dot(baseline_b) / length_b) ||
        differs(na2.dot(baseline_a) / length_a, nb2.dot(baseline_b) / length_b)) {
      return {};
    }
    const auto axes_a = axes_of(baseline_a, na1 + na2);
    const auto axes_b = axes_of(baseline_b, nb1 + nb2);
    if (!axes_a || !axes_b) return {};
    Eigen::Isometry3f T = Eigen::Isometry3f::Identity();
    T.linear() = *axes_a * axes_b->transpose();
    T.translation() = (a1 + a2) / 2 - T.linear() * ((b1 + b2) / 2);
    return T;
  }

  void judge(Candidate& candidate) const {
    // Every so many points, and first a fifth of them, spread as evenly: most poses are hopeless by that.
    constexpr std::size_t kPasses = 5;
    const std::size_t every = std::max<std::size_t>(1, b_.points.size() / kTestPoints);
    for (std::size_t pass = 0; pass < kPasses; ++pass) {
      judge_every(kPasses * every, pass * every, candidate);
      if (pass == 0 && candidate.met < static_cast<int>(kHopeless * kTestPoints / kPasses)) return;
    }
  }

  void judge_every(std::size_t every, std::size_t first, Candidate& candidate) const {
    for (std::size_t i = first; i < b_.points.size(); i += every) {
      const Vector3f p = candidate.T_a_b * b_.points.points_m[i];
      const Vector3f n = candidate.T_a_b.linear() * b_.points.normals[i];
      const auto nearest = a_.grid.nearest(p);
      if (!nearest || (a_.points.points_m[*nearest] - p).norm() > kNear * spacing_) continue;
      if (n.dot(a_.points.normals[*nearest]) > 0.7f) ++candidate.met;
    }
  }

  [[nodiscard]] bool is_same(const Pose& x, const Pose& y) const {
    const Pose between = x.inverse() * y;
    const double turn = Eigen::AngleAxisd(between.linear()).angle();
    const Eigen::Vector3d middle = b_.points.points_m[b_.points.size() / 2].cast<double>();
    return turn < kSameCoarseTurn && (x * middle - y * middle).norm() < double{kSameCoarsePlace} * spacing_;
  }

  const ScanLevel& a_;
  const ScanLevel& b_;
  std::vector<LookAlike> pairs_;
  std::uint64_t seed_;
  float spacing_;
};

}  // namespace

std::vector<Pose> search_coarsely(const ScanLevel& a, const std::vector<SurfaceFeature>& features_a, const ScanLevel& b,
                                  const std::vector<SurfaceFeature>& features_b, std::uint64_t seed) {
  return CoarseSearch(a, b, find_look_alikes(features_a, features_b), seed).best();
}

}  // namespace scanknit
