// DenseVolume: a whole volume in memory.
#pragma once

#include <cstddef>
#include <vector>

#include "extract/volume/volume_header.h"

namespace scanknit {

struct DenseVolume {
  VolumeHeader header;
  std::vector<float> samples;  ///< dims.prod() values, i fastest; NaN where nothing is known, never infinite

  [[nodiscard]] float at(int i, int j, int k) const {
    const auto row =
        static_cast<std::size_t>(k) * static_cast<std::size_t>(header.dims.y()) + static_cast<std::size_t>(j);
    return samples[row * static_cast<std::size_t>(header.dims.x()) + static_cast<std::size_t>(i)];
  }
};

}  // namespace scanknit
