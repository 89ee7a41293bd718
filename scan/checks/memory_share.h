// What of the memory budget, which is the process's, the volume may take.
#pragma once

#include <algorithm>
#include <cstddef>

#include "fusion/fusion_config.h"

namespace scanknit {

/// What the program takes beside the volume and meshes, MiB: libraries, threads, frames of 640 x 480 that are read
/// ahead, filtered and tracked.
inline constexpr std::size_t kProgramMib = 96;

/// Of a budget for the process, the volume's part: five sevenths of what the program leaves, since extraction makes a
/// mesh of up to two fifths of the volume's size beside it; at least a quarter, and at least what any scan needs. It
/// depends on nothing else: a volume that is full holds the same voxels in each run.
[[nodiscard]] inline std::size_t volume_budget_mib(std::size_t memory_budget_mib) {
  if (memory_budget_mib < kLeastMemoryBudgetMib) return memory_budget_mib;  // TsdfVolume::create() refuses it
  const std::size_t left_mib = memory_budget_mib - std::min(memory_budget_mib, kProgramMib);
  return std::max({left_mib / 7 * 5, memory_budget_mib / 4, kLeastMemoryBudgetMib});
}

/// The least budget whose part for the volume is `volume_mib`, rounded up.
[[nodiscard]] inline std::size_t budget_for_volume_mib(std::size_t volume_mib) {
  return std::min(kProgramMib + (volume_mib / 5 + 1) * 7, 4 * volume_mib);
}

/// The settings of a scan's volume: fusion.memory_budget becomes the volume's part of it.
[[nodiscard]] inline FusionConfig volume_config(FusionConfig config) {
  config.memory_budget_mib = volume_budget_mib(config.memory_budget_mib);
  return config;
}

}  // namespace scanknit
