// VectorPage: a page of rectangles and text in true size, as SVG or PDF.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "calibrate/print/target_shapes.h"

namespace scanknit {

/// Black, in Helvetica or what replaces it.
struct PageText {
  Eigen::Vector2d baseline_m;  ///< where the first letter stands
  double height_m = 0.0032;    ///< of the font
  std::string text;            ///< ASCII
  bool is_upwards = false;     ///< turned by 90 degrees, read from the right
};

/// Metres from the page's top left corner, y down.
struct VectorPage {
  Eigen::Vector2d size_m;
  std::vector<BlackRectangle> rectangles;
  std::vector<PageText> texts;
};

/// SVG 1.1, in millimetres.
[[nodiscard]] std::string svg_of(const VectorPage& page);

/// PDF 1.4 (ISO 32000-1), one page, in points of 1/72 inch. Asks the printing dialog not to scale.
[[nodiscard]] std::string pdf_of(const VectorPage& page);

}  // namespace scanknit
