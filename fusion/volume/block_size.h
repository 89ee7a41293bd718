// The size of a block, the unit in which the volume grows: an OpenVDB leaf.
#pragma once

#include <cstddef>

namespace scanknit {

inline constexpr int kBlockEdgeVoxels = 8;  ///< along each axis
inline constexpr std::size_t kBlockVoxels = 512;

}  // namespace scanknit
