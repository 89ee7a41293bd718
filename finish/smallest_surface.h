// Decides between matter and free space where nothing was observed: by the labelling with the smallest surface.
#pragma once

#include <cstdint>
#include <vector>

#include "finish/voxel_box.h"

namespace scanknit {

enum class VoxelLabel : std::uint8_t { kUnknown, kMatter, kFree };

/// Signed distances in voxels, negative in matter, for a box in which some voxels are known.
struct FilledField {
  std::vector<float> distance_vox;  ///< of unknown voxels; undefined for known ones
};

/// Reads `known_vox` where the label is not kUnknown. Labels the unknown voxels so that the surface is the smallest one
/// that agrees with the known voxels (total variation, whose minimum is unique: Chan, Esedoglu & Nikolova 2006; solved
/// by Chambolle & Pock 2011, algorithm 1, from coarse to fine; the first level whose voxels are no wider than
/// `band_voxels`, the known band, fixes the voxels far from the surface). Then smooths the distances so that the
/// surface meets the known one without a step. Distances stay within two voxels. The same bits for any number of
/// threads.
[[nodiscard]] FilledField fill_by_smallest_surface(const VoxelBox& box, const std::vector<VoxelLabel>& labels,
                                                   const std::vector<float>& known_vox, double band_voxels);

/// Bytes that it needs for each voxel of the box, without its arguments.
inline constexpr std::size_t kFillBytesPerVoxel = 28;

}  // namespace scanknit
