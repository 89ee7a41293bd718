// ClassVolumes: a volume for each class of the masks.
#pragma once

#include <bitset>
#include <cstdint>
#include <map>
#include <vector>

#include "core/frame.h"
#include "core/pose.h"
#include "core/result.h"
#include "fusion/volume/tsdf_volume.h"
#include "scan/frames/depth_samples.h"
#include "scan/scan_config.h"

namespace scanknit {

/// One class, as it was fused.
struct ClassVolume {
  TsdfVolume volume;
  DepthSamples samples;  ///< of its depth, if they are kept
};

class ClassVolumes {
 public:
  /// `config` outlives it.
  ClassVolumes(const ScanConfig& config, bool keeps_samples) : config_(config), keeps_samples_(keeps_samples) {}

  /// Fuses each class of a frame, which has labels, is filtered, and has this pose. Errors: those of integrate() and
  /// TsdfVolume::create().
  [[nodiscard]] Result<void> integrate(const Frame& frame, const Pose& T_world_camera);

  /// By their labels.
  [[nodiscard]] std::map<std::uint8_t, ClassVolume>& all() { return classes_; }
  [[nodiscard]] bool has_left_out() const { return has_left_out_; }  ///< there are more than kMostClasses

 private:
  using Labels = std::bitset<256>;
  [[nodiscard]] static Labels labels_of(const Frame& frame);
  [[nodiscard]] Result<void> add_new(const Labels& labels);
  [[nodiscard]] std::size_t memory_bytes() const;

  const ScanConfig& config_;
  bool keeps_samples_;
  std::map<std::uint8_t, ClassVolume> classes_;
  bool has_left_out_ = false;
};

}  // namespace scanknit
