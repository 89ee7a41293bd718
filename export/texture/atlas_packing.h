// Packing: where each chart of an atlas lies in the texture.
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
  int width = 0, height = 0;       ///< of the texture
  std::vector<AtlasPlace> places;  ///< one a box, in their order
};

/// Puts boxes, the highest first, where the skyline of those before is lowest. No two overlap, none is turned. As
/// square as it comes out; sides are multiples of four. Nothing when they do not fit into `max_side` x `max_side`, a
/// multiple of four.
[[nodiscard]] std::optional<Packing> pack_boxes(std::span<const AtlasBox> boxes, int max_side);

}  // namespace scanknit
