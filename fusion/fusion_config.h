// FusionConfig: the volume, and how frames are integrated. The keys of `fusion:` in YAML.
#pragma once

#include <cstddef>

#include "core/noise_model.h"

namespace scanknit {

/// With less, a scan round the origin has almost no room for voxels: the inner nodes of the trees alone take about
/// seven.
inline constexpr std::size_t kLeastMemoryBudgetMib = 8;
inline constexpr std::size_t kMostMemoryBudgetMib = 1 << 24;

struct FusionConfig {
  double voxel_size_m = 0.004;
  double truncation_voxels = 4;  ///< the band's half-width, at least this many voxels ...
  double truncation_sigmas = 3;  ///< ... and at least this many sigma(z) of the observation; 0: fixed band
  NoiseModel noise;
  double max_weight = 4095;              ///< beyond this weight, new observations replace old ones
  bool carve_free_space = true;          ///< update known voxels in front of the surface towards +truncation
  bool loop_closure = true;              ///< distribute the drift of a tracked walk that comes back, at its end
  std::size_t memory_budget_mib = 4096;  ///< kLeastMemoryBudgetMib to kMostMemoryBudgetMib
};

}  // namespace scanknit
