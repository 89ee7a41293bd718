// StillScene: the depth of everything that does not move in front of a fixed camera, for each pixel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/image.h"
#include "core/noise_model.h"

namespace scanknit {

class StillScene {
 public:
  /// An empty scene: nothing stands still.
  StillScene() = default;

  /// Learns from depth pictures of the same size, spread over a whole recording. A pixel is still if most of its
  /// readings have the same depth, or if a tenth of them have the same depth far behind all others: then something
  /// passed in front of it. If hardly any pixel is still, the camera moved, and no pixel counts as still. Holes and
  /// noise do no harm. If other depths occur much more rarely at a pixel than elsewhere, they are a hand or a
  /// passer-by. The same for any number of threads.
  [[nodiscard]] static StillScene learn(const std::vector<DepthImage>& samples, const NoiseModel& noise);

  [[nodiscard]] bool empty() const { return depth_m_.empty(); }
  /// Depth of still pixels; 0: not still. Without pixels if empty().
  [[nodiscard]] const DepthImage& depth_m() const { return depth_m_; }

  /// Sets depth to 0 for everything that stands still or is behind it, for pixels where something else rarely passes,
  /// and for isolated pixels that remain. Does nothing unless `depth_m` has the samples' size.
  void remove_from(DepthImage& depth_m) const;

 private:
  [[nodiscard]] bool is_other(float z_m, float still_m) const;
  void find_rare(const std::vector<DepthImage>& samples);

  DepthImage depth_m_;
  Image<std::uint8_t> is_rare_;
  NoiseModel noise_;
};

}  // namespace scanknit
