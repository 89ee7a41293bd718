// Registers several scans of one object.
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

/// The poses that are known beforehand.
struct AlignPriors {
  std::vector<std::optional<Pose>> T_world_scan;  ///< of each scan; empty: nothing is known
  /// T_from_to of pairs (from < to), by markers for example.
  std::map<std::pair<std::size_t, std::size_t>, Pose> T_from_to;
  /// For each scan: T_world_scan may fix motions that the shape leaves open; poses of pairs always may. Empty: none
  /// may.
  std::vector<bool> may_fix_motion = {};
  bool are_final = false;  ///< T_world_scan of every scan is final: pairs are measured, but no scan moves
};

/// Two scans, from < to.
struct AlignedPair {
  std::size_t from = 0, to = 0;
  Pose T_from_to = Pose::Identity();  ///< as measured; from the poses if the pair was rejected
  PairMeasure measure;                ///< at the final poses for a pair that counts, else at the best pose found
  PairJudgement judgement;
  PairStart start = PairStart::kSearch;
  double off_m = 0;  ///< distance of the final poses from the pair's own, at the scan's middle
};

struct Alignment {
  AlignScale scale;
  std::vector<Pose> T_world_scan;  ///< of every scan; identity for one that was not placed
  std::vector<bool> is_placed;     ///< connected to the first scan by pairs that count
  std::vector<AlignedPair> pairs;  ///< all of them, by (from, to)
};

/// Called with `done` of `total` pairs. False ends the work: the result has only the pairs compared so far, and no
/// poses.
using AlignProgress = std::function<bool(std::size_t done, std::size_t total)>;

/// For every pair: coarse search (unless a prior fits), fine registration, and a verdict from overlap, residual,
/// contradictions of free space, and how well the shape determines the motion. Then a pose graph of all pairs that
/// count. Rejects pairs that contradict the others. If a pair could slide, a prior that may fix motions does. Checks
/// rejected pairs again at the poses that the other pairs give them. The world is the first scan's frame, moved by its
/// prior if it has one. The same bits for any number of threads. Error: as surface_features(), if a pair needs the
/// coarse search.
[[nodiscard]] Result<Alignment> align_scans(const std::vector<ScanModel>& models, const AlignPriors& priors,
                                            const AlignProgress& progress = {});

}  // namespace scanknit
