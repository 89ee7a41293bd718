// Coarse registration: where one scan belongs in another, when nothing is known.
#pragma once

#include <cstdint>
#include <vector>

#include "core/pose.h"
#include "fusion/align/fine_match.h"
#include "fusion/align/local_features.h"

namespace scanknit {

/// Poses T_a_b that are worth a closer look, the best first. Local features that look alike are paired; two such pairs
/// with their normals give a pose (Drost et al. 2010 call them oriented point pairs), after prerejection by what a
/// rigid motion leaves as it is: the distance, and the angles of the normals (as PCL's SampleConsensusPrerejective does
/// by Buch et al. 2013, which draws from rand() and with three points needs many more draws where overlap is small).
/// Drawn from numbers that `seed` fixes; the same bits for any number of threads.
[[nodiscard]] std::vector<Pose> search_coarsely(const ScanLevel& a, const std::vector<SurfaceFeature>& features_a,
                                                const ScanLevel& b, const std::vector<SurfaceFeature>& features_b,
                                                std::uint64_t seed);

}  // namespace scanknit
