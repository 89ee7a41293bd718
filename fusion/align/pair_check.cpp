#include "fusion/align/pair_check.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

namespace scanknit {
namespace {

using Eigen::Vector3f;

constexpr float kMeets = 2;  // spacings from the nearest point of the other scan, and
constexpr float kLeastCheckedCosine = 0.8f;
constexpr float kInTheWay = 4;   // spacings before the surface: more than what does not fit by noise
constexpr double kFacing = 0.5;  // cosine: steeper than this a scanner may well see nothing
constexpr std::size_t kMostCheckedPoints = 8000;

// What makes a pair good, acceptable; see docs/align.md. Overlaps in shares, residuals in spacings.
constexpr double kGoodOverlap = 0.25, kAcceptableOverlap = 0.12, kUnseenOverlap = 0.3;
constexpr double kGoodResidual = 0.35, kAcceptableResidual = 0.55;
constexpr double kGoodContradicted = 0.005, kAcceptableContradicted = 0.015;
constexpr double kGoodMissing = 0.01, kAcceptableMissing = 0.02;
constexpr double kGoodStrength = 0.004;

/// What was found of one point.
struct PointFinding {
  bool meets = false;
  bool is_in_the_way = false;
  bool is_missing = false;
  float residual_m = 0;
};

struct SideMeasure {
  std::size_t points = 0, meeting = 0, in_the_way = 0, missing = 0;
  double squares = 0;
};

/// True where one of the sights looked through the point, and through its surroundings, at something behind.
bool is_in_the_way(const ScanModel& model, const Eigen::Vector3d& p, float margin_m) {
  return std::any_of(model.sights.begin(), model.sights.end(), [&](const ModelSight& sight) {
    const Eigen::Vector3d p_view = sight.T_scan_view.inverse() * p;
    const auto before = sight.view.least_before_m(p_view);
    if (!before || *before < margin_m) return false;
    const auto front = sight.view.front_of(p_view);
    return front && front->distance_m > margin_m;
  });
}

/// True where one of the sights faced the point, and saw nothing there nor round it.
bool is_missing(const ScanModel& model, const Eigen::Vector3d& p, const Eigen::Vector3d& n) {
  return std::any_of(model.sights.begin(), model.sights.end(), [&](const ModelSight& sight) {
    const Pose T_view_scan = sight.T_scan_view.inverse();
    const Eigen::Vector3d p_view = T_view_scan * p;
    if (!sight.view.sight().look(p_view)) return false;
    const double slope = -(T_view_scan.linear() * n).dot(sight.view.sight().direction(p_view));
    return slope > kFacing && sight.view.is_empty_around(p_view);
  });
}

/// The points of `from` against `to`.
SideMeasure measure_side(const ScanLevel& from, const ScanLevel& to, const ScanModel& to_model, const Pose& T_to_from) {
  const std::size_t every =
      std::max<std::size_t>(1, (from.points.size() + kMostCheckedPoints - 1) / kMostCheckedPoints);
  std::vector<PointFinding> findings((from.points.size() + every - 1) / every);
  const Eigen::Isometry3f T = T_to_from.cast<float>();
  const auto spacing = static_cast<float>(to.spacing_m);
  tbb::parallel_for(std::size_t{0}, findings.size(), [&](std::size_t i) {
    PointFinding& finding = findings[i];
    const Vector3f p = T * from.points.points_m[i * every];
    const Vector3f n = T.linear() * from.points.normals[i * every];
    const auto nearest = to.grid.nearest(
        p, [&](std::uint32_t candidate) { return n.dot(to.points.normals[candidate]) > kLeastCheckedCosine; });
    if (nearest) {
      const Vector3f off = to.points.points_m[*nearest] - p;
      finding.meets = off.norm() < kMeets * spacing;
      finding.residual_m = off.dot((n + to.points.normals[*nearest]).normalized());
    }
    if (finding.meets) return;
    finding.is_in_the_way = is_in_the_way(to_model, p.cast<double>(), kInTheWay * spacing);
    finding.is_missing = is_missing(to_model, p.cast<double>(), n.cast<double>());
  });
  SideMeasure side{.points = findings.size()};
  for (const PointFinding& finding : findings) {
    if (finding.meets) {
      ++side.meeting;
      side.squares += double{finding.residual_m} * double{finding.residual_m};
    }
    if (finding.is_in_the_way) ++side.in_the_way;
    if (finding.is_missing) ++side.missing;
  }
  return side;
}

std::string percent(double share) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1f %%", 100 * share);
  return text.data();
}

double share_of(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

}  // namespace

PairMeasure measure_pair(const PreparedScan& a, const PreparedScan& b, const Pose& T_a_b, CheckLevel level) {
  const ScanLevel& level_a = level == CheckLevel::kFine ? a.fine : a.coarse;
  const ScanLevel& level_b = level == CheckLevel::kFine ? b.fine : b.coarse;
  const SideMeasure of_b = measure_side(level_b, level_a, *a.model, T_a_b);
  const SideMeasure of_a = measure_side(level_a, level_b, *b.model, T_a_b.inverse());
  PairMeasure measure;
  const bool a_is_smaller = level_a.points.size() < level_b.points.size();
  measure.overlap = a_is_smaller ? share_of(of_a.meeting, of_a.points) : share_of(of_b.meeting, of_b.points);
  const std::size_t meeting = of_a.meeting + of_b.meeting;
  if (meeting > 0) measure.residual_m = std::sqrt((of_a.squares + of_b.squares) / static_cast<double>(meeting));
  measure.is_seen = !a.model->sights.empty() || !b.model->sights.empty();
  // The worse of both: what one scanner sees may be hidden from the other.
  measure.contradicted = std::max(share_of(of_a.in_the_way, of_a.in_the_way + of_a.meeting),
                                  share_of(of_b.in_the_way, of_b.in_the_way + of_b.meeting));
  measure.missing = std::max(share_of(of_a.missing, of_a.missing + of_a.meeting),
                             share_of(of_b.missing, of_b.missing + of_b.meeting));
  const auto against = [](const SideMeasure& side) {
    return share_of(std::max(side.in_the_way, side.missing), side.points);
  };
  measure.against = std::max(against(of_a), against(of_b));
  return measure;
}

PairJudgement judge_pair(const PairMeasure& measure, double spacing_m) {
  const auto refused = [](std::string reason) { return PairJudgement{PairVerdict::kUnacceptable, std::move(reason)}; };
  const double residual = measure.residual_m / spacing_m;
  const double least_overlap = measure.is_seen ? kAcceptableOverlap : kUnseenOverlap;
  if (measure.overlap < least_overlap) {
    return refused("too little overlap: " + percent(measure.overlap) + ", at least " + percent(least_overlap) +
                   " is needed");
  }
  if (measure.contradicted > kAcceptableContradicted) {
    return refused("one scan is in the way of the other: " + percent(measure.contradicted) +
                   " of it lies where the other scanner looked through");
  }
  if (measure.missing > kAcceptableMissing) {
    return refused("one scan shows what the other does not: " + percent(measure.missing) +
                   " of it faced the other scanner, which saw nothing there");
  }
  if (residual > kAcceptableResidual) return refused("the surfaces do not fit: the residual is as large as by chance");
  if (measure.least_strength < kLeastStrength && !measure.is_fixed_by_prior) {
    return refused("they could slide along each other: what they share is flat, round or a cylinder");
  }
  if (measure.least_strength < kLeastStrength) {
    return {PairVerdict::kAcceptable, "held by the markers or the initial poses: by its shape alone it could slide"};
  }
  if (measure.overlap < kGoodOverlap) return {PairVerdict::kAcceptable, "little overlap"};
  if (measure.contradicted > kGoodContradicted) return {PairVerdict::kAcceptable, "something is in the way"};
  if (measure.missing > kGoodMissing) return {PairVerdict::kAcceptable, "something is missing"};
  if (residual > kGoodResidual) return {PairVerdict::kAcceptable, "large residual"};
  if (measure.least_strength < kGoodStrength) return {PairVerdict::kAcceptable, "held by little"};
  return {PairVerdict::kGood, ""};
}

double score_of(const PairMeasure& measure, double spacing_m) {
  const double fit = std::max(0.0, 1 - measure.residual_m / (double{kMeets} * spacing_m));
  return measure.overlap * fit * fit - 4 * (measure.contradicted + measure.missing);
}

}  // namespace scanknit
