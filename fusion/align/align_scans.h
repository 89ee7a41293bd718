// Several scans of one thing, brought together.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/pose.h"
#include "core/result.h"
#include "fusion/align/pair_check.h"
#include "fusion/align/scan_model.h"

namespace scanknit {

/// What is known beforehand.
struct AlignPriors {
  std::vector<std::optional<Pose>> T_world_scan;  ///< of each scan; empty: nothing is known
  /// T_from_to of pairs (from < to), by markers for example.
  std::map<std::pair<std::size_t, std::size_t>, Pose> T_from_to;
  /// T_world_scan of the scan was stated to hold what the shape does not; poses of pairs always are. Empty: none is.
  std::vector<bool> may_hold = {};
  bool are_final = false;  ///< T_world_scan is taken as it is, of every scan: pairs are measured, nothing is moved
};

/// Two scans, from < to.
struct AlignedPair {
  std::size_t from = 0, to = 0;
  Pose T_from_to = Pose::Identity();  ///< as measured; where the poses put it if the pair was refused
  PairMeasure measure;                ///< at the final poses for a pair that counts, else at the best that was found
  PairJudgement judgement;
  std::string start;  ///< how it was found: "search", "prior", "others", "given"
  double off_m = 0;   ///< how far the final poses are from what the pair itself says, at the scan's middle
};

struct Alignment {
  AlignScale scale;
  std::vector<Pose> T_world_scan;  ///< of every scan; identity for one that was not placed
  std::vector<bool> is_placed;     ///< connected to the first scan by pairs that count
  std::vector<AlignedPair> pairs;  ///< all of them, by (from, to)
};

/// `done` of `total` pairs. False ends the work: only the pairs that were compared are returned, and nothing is placed.
using AlignProgress = std::function<bool(std::size_t done, std::size_t total)>;

/// Every pair: coarse search (unless a prior fits), fine registration, and a judgement by overlap, residual, what is in
/// the way, and how firmly the shape holds it; then all pairs that count in a pose graph. A pair that contradicts the
/// others is refused; a pair that could slide is held by a prior that may hold; one that was refused, but has a place
/// by the others, is looked at again there. The world is the first scan's frame, moved by its prior where it has one.
/// The same bits for any number of threads. Error: surface_features()'s, where a pair has to be searched for.
[[nodiscard]] Result<Alignment> align_scans(const std::vector<ScanModel>& models, const AlignPriors& priors,
                                            const AlignProgress& progress = {});

}  // namespace scanknit
