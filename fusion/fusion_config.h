// FusionConfig: the volume, and how frames are integrated. TurntableConfig: what is known of a turntable. The keys of
// `fusion:` and `turntable:` in YAML.
#pragma once

#include <cstddef>
#include <optional>

#include "core/noise_model.h"

namespace scanknit {

/// With less, a scan round the origin has almost no room for voxels: the inner nodes of the trees alone take about
/// seven.
inline constexpr std::size_t kLeastMemoryBudgetMib = 8;
inline constexpr std::size_t kMostMemoryBudgetMib = 1 << 24;

/// What the frames' silhouettes add to their depth.
enum class SilhouetteUse {
  kOff,
  kCarve,  ///< their visual hull fills what depth left of the thing
};

/// Whether a volume that is larger than the memory is fused brick by brick, and in bricks of how many voxels.
enum class BrickSize {
  kOff = -1,
  kAuto = 0,  ///< only where the volume exceeds its budget; then as large as the budget allows
  k64 = 64,
  k128 = 128,
  k256 = 256,
  k512 = 512,
};

struct FusionConfig {
  double voxel_size_m = 0.004;   ///< edge of a voxel, >= 0.000001
  double truncation_voxels = 4;  ///< the band's half-width, at least this many voxels (> 0) ...
  double truncation_sigmas = 3;  ///< ... and at least this many sigma(z) of the observation; 0: fixed band
  NoiseModel noise;              ///< of a scan: see ScanConfig::noise
  double max_weight = 4095;      ///< beyond this weight, new observations replace old ones; > 0, at most 4095
  bool carve_free_space = true;  ///< update known voxels in front of the surface towards +truncation
  bool loop_closure = true;      ///< distribute the drift of a tracked walk that comes back, at its end
  SilhouetteUse silhouettes = SilhouetteUse::kOff;
  BrickSize bricks = BrickSize::kAuto;   ///< of scans whose poses are known
  std::size_t memory_budget_mib = 4096;  ///< kLeastMemoryBudgetMib to kMostMemoryBudgetMib
};

/// What is known of a turntable, and how to use it. The keys of `turntable:`.
struct TurntableConfig {
  bool is_enabled = false;           ///< the scanner stands still and the object turns
  bool cuts = true;                  ///< cut away what does not turn with the object, and the disc
  bool closes_base = true;           ///< a plane closes the object where it stood on the disc
  double rpm = 0;                    ///< turns a minute, steady, >= 0; 0: not known. Needs frames with times
  double step_degrees = 0;           ///< between two frames, steady, 0 to 170; 0: not known
  double angle_sigma_degrees = 0.5;  ///< standard deviation of known angles, > 0
  /// Of silhouettes, which do not tell a size: how far before the camera the axis is. Nothing: not known.
  std::optional<double> distance_m = {};
};

}  // namespace scanknit
