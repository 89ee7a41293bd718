// Whether two scans that were brought together belong there.
#pragma once

#include <string>

#include "core/pose.h"
#include "fusion/align/fine_match.h"
#include "fusion/align/scan_model.h"

namespace scanknit {

/// One scan with all that pairs of scans are compared by.
struct PreparedScan {
  const ScanModel* model;
  ScanLevel coarse, fine;
};

struct PairMeasure {
  double overlap = 0;       ///< share of the scan with less area that meets the other one, 0 to 1
  double residual_m = 0;    ///< root mean square distance along normals of what meets
  double contradicted = 0;  ///< of what one scanner looked at, the share that the other scan has in its way, 0 to 1
  double missing = 0;       ///< ... and the share that it should have seen, but saw nothing there
  bool is_seen = false;     ///< one of the scans tells from where it was seen: only then is `contradicted` known
  double against = 0;  ///< share of all points of a scan that is in the way or missing, the larger of the two, 0 to 1
  double least_strength = 0;  ///< FineMatch's
  bool is_held = false;       ///< what the shape does not hold, a prior does
};

/// At the scale of `level`: which of the levels is compared.
enum class CheckLevel { kCoarse, kFine };
[[nodiscard]] PairMeasure measure_pair(const PreparedScan& a, const PreparedScan& b, const Pose& T_a_b,
                                       CheckLevel level);

/// Below it two scans could slide along each other (PairMeasure::least_strength).
inline constexpr double kLeastStrength = 0.0015;

enum class PairVerdict { kGood, kAcceptable, kUnacceptable };

/// "good", "acceptable", "unacceptable".
[[nodiscard]] const char* to_string(PairVerdict verdict);

struct PairJudgement {
  PairVerdict verdict;
  std::string reason;  ///< empty when good
};

/// `spacing_m`: of the fine level, which distances are judged by.
[[nodiscard]] PairJudgement judge_pair(const PairMeasure& measure, double spacing_m);

/// One number to choose between poses of a pair by; larger is better.
[[nodiscard]] double score_of(const PairMeasure& measure, double spacing_m);

}  // namespace scanknit
