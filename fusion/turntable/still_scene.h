// StillScene: what does not move before a camera that stands still, pixel by pixel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/image.h"
#include "core/noise_model.h"

namespace scanknit {

class StillScene {
 public:
  /// Nothing stands still.
  StillScene() = default;

  /// From depth pictures of one size, spread over a whole recording. A pixel is still where most of what it saw lies at
  /// one depth; or where a tenth of it lies at one depth far behind all the rest: something passed in front of it.
  /// Where hardly a pixel is still the camera moved, and nothing is. Holes and noise do no harm. Where something else
  /// than the usual comes by much more rarely than elsewhere, it is a hand, or a passer-by. The same for any number of
  /// threads.
  [[nodiscard]] static StillScene learn(const std::vector<DepthImage>& samples, const NoiseModel& noise);

  [[nodiscard]] bool empty() const { return depth_m_.empty(); }
  /// 0: not known to be still. Without pixels if empty().
  [[nodiscard]] const DepthImage& depth_m() const { return depth_m_; }

  /// Depth of what stands still, or lies behind it, becomes 0; so do pixels where rarely anything comes by, and lone
  /// ones that remain. `depth_m` has the samples' size, or nothing is done.
  void remove_from(DepthImage& depth_m) const;

 private:
  [[nodiscard]] bool is_other(float z_m, float still_m) const;
  void find_rare(const std::vector<DepthImage>& samples);

  DepthImage depth_m_;
  Image<std::uint8_t> is_rare_;
  NoiseModel noise_;
};

}  // namespace scanknit
