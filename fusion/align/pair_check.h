// Decides whether the pose between two registered scans is right.
#pragma once

#include <string>

#include "core/pose.h"
#include "fusion/align/fine_match.h"
#include "fusion/align/pair_verdict.h"
#include "fusion/align/scan_model.h"

namespace scanknit {

/// One scan with all data that the comparison of pairs needs.
struct PreparedScan {
  const ScanModel* model;
  ScanLevel coarse, fine;
};

struct PairMeasure {
  double overlap = 0;         ///< share of the smaller scan's area that meets the other scan, 0 to 1
  double residual_m = 0;      ///< root mean square distance along normals where they meet
  double contradicted = 0;    ///< share of what one scanner saw that the other scan would hide, 0 to 1
  double missing = 0;         ///< share that a scanner should have seen, but where it saw nothing
  bool is_seen = false;       ///< the scanner's position is known for one of the scans; else `contradicted` is unknown
  double against = 0;         ///< share of a scan's points that contradict the other, the larger one, 0 to 1
  double least_strength = 0;  ///< FineMatch's
  bool is_fixed_by_prior = false;  ///< a prior fixes the motions that the shape leaves open
};

/// Which level is compared.
enum class CheckLevel { kCoarse, kFine };
[[nodiscard]] PairMeasure measure_pair(const PreparedScan& a, const PreparedScan& b, const Pose& T_a_b,
                                       CheckLevel level);

/// Below this PairMeasure::least_strength, two scans could slide along each other.
inline constexpr double kLeastStrength = 0.0015;

struct PairJudgement {
  PairVerdict verdict;
  std::string reason;  ///< empty when good
};

/// `spacing_m`: of the fine level, the scale of all distances.
[[nodiscard]] PairJudgement judge_pair(const PairMeasure& measure, double spacing_m);

/// A score to choose between poses of a pair; larger is better.
[[nodiscard]] double score_of(const PairMeasure& measure, double spacing_m);

}  // namespace scanknit
