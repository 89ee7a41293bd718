// What OpenCV does for this room: in a module, libscanknit_calibrate_opencv.so, which only boards need.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "calibrate/target/calibration_target.h"
#include "core/image.h"
#include "core/system/module.h"

namespace scanknit {

/// The cells of a tag of the family 36h11, border included.
struct TagCells {
  std::array<bool, static_cast<std::size_t>(kTagCells) * kTagCells> black{};  ///< row by row from the top left

  [[nodiscard]] bool is_black(int column, int row) const {
    return black[static_cast<std::size_t>(row) * kTagCells + static_cast<std::size_t>(column)];
  }
};

/// A tag in a picture: the corners of its black border, clockwise from the tag's top left; pixels, some tenths exact.
struct FoundTag {
  int id = 0;
  std::array<Eigen::Vector2d, 4> corners;
};

/// A point about which the picture is the same after half a turn, to be placed exactly.
struct RoughCorner {
  Eigen::Vector2d pixel;
  double radius_px = 0;  ///< so far round the point that holds; at least 1
};

struct CalibrateOpenCv {
  /// 0 <= id < kTagsOfFamily.
  TagCells (*tag_cells)(int id);
  /// All tags of the family, in no order.
  std::vector<FoundTag> (*find_tags)(const Image<std::uint8_t>& grey);
  /// Moves each corner to where the gradients round it meet (Foerstner 1987). Corners must lie in the picture.
  void (*refine)(const Image<std::uint8_t>& grey, std::vector<RoughCorner>& corners);
};

/// Error (kInternal): load_module()'s.
[[nodiscard]] inline Result<const CalibrateOpenCv*> load_calibrate_opencv() {
  return load_module<CalibrateOpenCv>("calibrate_opencv",
                                      "Install scanknit again; it needs Debian's libopencv-contrib406");
}

}  // namespace scanknit
