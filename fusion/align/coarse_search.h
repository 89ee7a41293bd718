// Coarse registration: finds the pose of one scan in another without any prior.
#pragma once

#include <cstdint>
#include <vector>

#include "core/pose.h"
#include "fusion/align/fine_match.h"
#include "fusion/align/local_features.h"

namespace scanknit {

/// Candidates for T_a_b, the best first. Pairs points with similar local features; two such pairs with their normals
/// give a pose (Drost et al. 2010 call them oriented point pairs), unless they differ in what a rigid motion preserves:
/// the distance, and the angles of the normals (as PCL's SampleConsensusPrerejective does by Buch et al. 2013, which
/// draws from rand() and with three points needs many more draws where overlap is small). `seed` determines the random
/// draws; the same bits for any number of threads.
[[nodiscard]] std::vector<Pose> search_coarsely(const ScanLevel& a, const std::vector<SurfaceFeature>& features_a,
                                                const ScanLevel& b, const std::vector<SurfaceFeature>& features_b,
                                                std::uint64_t seed);

}  // namespace scanknit
