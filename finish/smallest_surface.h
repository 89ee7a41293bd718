// Decides between matter and free space where nothing was observed: by the labelling with the smallest surface.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "finish/voxel_box.h"

namespace scanknit {

enum class VoxelLabel : std::uint8_t { kUnknown, kMatter, kFree };

/// Signed distances of the voxels of a box, negative in matter; only those of known voxels mean anything.
struct KnownDistances {
  std::span<const float> distance_m;
  float voxel_m = 1;

  [[nodiscard]] float in_voxels(std::size_t i) const { return distance_m[i] / voxel_m; }
};

/// Signed distances in voxels, negative in matter, for a box in which some voxels are known.
struct FilledField {
  std::vector<float> distance_vox;  ///< of unknown voxels; undefined for known ones. Empty: `bytes` are too many
  std::size_t bytes = 0;            ///< of memory that it took, or would take, without its arguments
};

/// Labels the unknown voxels so that the surface is the smallest one that agrees with the known voxels (total
/// variation, whose minimum is unique: Chan, Esedoglu & Nikolova 2006; solved by Chambolle & Pock 2011, algorithm 1,
/// from coarse to fine; the first level whose voxels are no wider than `band_voxels`, the known band, fixes the voxels
/// far from the surface). Then smooths the distances so that the surface meets the known one without a step. Distances
/// stay within two voxels. The same bits for any number of threads. Stops before the finest level, which takes most of
/// the time and 5 bytes for each voxel and 16 for each that is still open then, if that is more than `max_bytes`.
[[nodiscard]] FilledField fill_by_smallest_surface(const VoxelBox& box, std::span<const VoxelLabel> labels,
                                                   const KnownDistances& known, double band_voxels,
                                                   std::size_t max_bytes = std::numeric_limits<std::size_t>::max());

/// Bytes that it needs for each voxel of the box at least.
inline constexpr std::size_t kLeastFillBytesPerVoxel = 7;

}  // namespace scanknit
