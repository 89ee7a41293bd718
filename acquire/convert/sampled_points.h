// SampledPoints: coloured points of a recording, from which the training of a Gaussian splatting begins. Private to the
// room.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>
#include <vector>

#include "core/frame.h"
#include "core/image.h"

namespace scanknit {

struct SampledPoint {
  Eigen::Vector3f p_world;  ///< metres
  Rgb8 colour;
};

/// At most 100,000 of the points that depth and colour see, each with the same chance (Vitter 1985, algorithm R), and
/// the same ones every time.
class SampledPoints {
 public:
  /// Offers every fourth pixel of every fourth row. `frame` has a pose and colour.
  void add(const Frame& frame);
  [[nodiscard]] const std::vector<SampledPoint>& points() const { return points_; }

 private:
  void offer(const SampledPoint& point);

  std::vector<SampledPoint> points_;
  std::uint64_t offered_ = 0;
  std::mt19937_64 random_{1};
};

}  // namespace scanknit
