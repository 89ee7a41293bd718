// What is matter where nobody looked: the labelling whose surface is smallest.
#pragma once

#include <cstdint>
#include <vector>

#include "finish/voxel_box.h"

namespace scanknit {

enum class VoxelLabel : std::uint8_t { kUnknown, kMatter, kFree };

/// Signed distances, in voxels, negative in matter, for a box of voxels some of which are known.
struct FilledField {
  std::vector<float> distance_vox;  ///< of unknown voxels; what it says of known ones has no meaning
};

/// `known_vox` is read where the label is not kUnknown. The labelling of the unknown voxels has the least surface that
/// agrees with the known ones (total variation, which has one minimum: Chan, Esedoglu & Nikolova 2006; solved by
/// Chambolle & Pock 2011, algorithm 1, from coarse to fine; voxels deep within either side are settled at the first
/// level whose voxels are no wider than `band_voxels`, the known band). Distances are then smoothed so that the
/// surface meets the known one without a step. They stay within two voxels. The same bits for any number of threads.
[[nodiscard]] FilledField fill_by_smallest_surface(const VoxelBox& box, const std::vector<VoxelLabel>& labels,
                                                   const std::vector<float>& known_vox, double band_voxels);

/// Bytes it takes for each voxel of the box, its arguments left out.
inline constexpr std::size_t kFillBytesPerVoxel = 28;

}  // namespace scanknit
