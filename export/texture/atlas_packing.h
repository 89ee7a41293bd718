// Packs the charts of an atlas into the texture.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace scanknit {

struct AtlasBox {
  int width = 0, height = 0;  ///< >= 1
};

struct AtlasPlace {
  int x = 0, y = 0;
};

struct Packing {
  int width = 0, height = 0;       ///< size of the texture
  std::vector<AtlasPlace> places;  ///< one for each box, in their order
};

/// Places boxes, the highest first, where the skyline of the placed ones is lowest. Boxes do not overlap and are not
/// rotated. The texture is about square; its sides are multiples of four. Nothing when the boxes do not fit into
/// `max_side` x `max_side`, a multiple of four.
[[nodiscard]] std::optional<Packing> pack_boxes(std::span<const AtlasBox> boxes, int max_side);

}  // namespace scanknit
