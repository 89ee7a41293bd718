// typical_depth_m: how far away what a depth picture shows is, as one number.
#pragma once

#include <utility>
#include <vector>

#include "core/image.h"
#include "core/median.h"

namespace scanknit {

/// The median of every 16th pixel that has depth, metres; 0 without any.
[[nodiscard]] inline float typical_depth_m(const DepthImage& depth_m) {
  std::vector<float> depths;
  constexpr int kStep = 4;
  for (int y = 0; y < depth_m.height(); y += kStep) {
    for (int x = 0; x < depth_m.width(); x += kStep) {
      if (depth_m.at(x, y) > 0) depths.push_back(depth_m.at(x, y));
    }
  }
  return median(std::move(depths));
}

}  // namespace scanknit
