#include "scan/classes/class_volumes.h"

#include <algorithm>
#include <utility>

#include "acquire/masks/frame_mask.h"
#include "fusion/integrate/integrate.h"
#include "scan/checks/memory_share.h"
#include "scan/classes/scan_classes.h"

namespace scanknit {

Result<void> ClassVolumes::integrate(const Frame& frame, const Pose& T_world_camera) {
  const Labels labels = labels_of(frame);
  if (auto added = add_new(labels); !added) return added;
  const bool looks_outside = config_.acquire.mask_means == MaskMeans::kFree;
  for (auto& [label, one] : classes_) {
    if (!labels[label] && !looks_outside) continue;
    const Frame part = frame_of_class(frame, label, config_.acquire.mask_means);
    const std::size_t others_mib = (memory_bytes() - one.volume.memory_bytes()) >> 20;
    const std::size_t budget_mib = volume_budget_mib(config_.fusion.memory_budget_mib);
    one.volume.set_memory_budget_mib(budget_mib - std::min(budget_mib, others_mib));
    if (auto fused = scanknit::integrate(part, T_world_camera, one.volume); !fused) return fused.error();
    if (labels[label] && keeps_samples_) one.samples.add(part);
  }
  return {};
}

ClassVolumes::Labels ClassVolumes::labels_of(const Frame& frame) {
  Labels labels;
  for (const std::uint8_t label : frame.labels.pixels()) labels.set(label);
  return labels.reset(0);
}

Result<void> ClassVolumes::add_new(const Labels& labels) {
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const auto label = static_cast<std::uint8_t>(i);
    if (!labels[i] || classes_.contains(label)) continue;
    if (classes_.size() >= kMostClasses) {
      has_left_out_ = true;
      return {};
    }
    auto volume = TsdfVolume::create(volume_config(config_.fusion));
    if (!volume) return volume.error();
    classes_.emplace(label, ClassVolume{*std::move(volume), {}});
  }
  return {};
}

std::size_t ClassVolumes::memory_bytes() const {
  std::size_t bytes = 0;
  for (const auto& [label, one] : classes_) bytes += one.volume.memory_bytes();
  return bytes;
}

}  // namespace scanknit
