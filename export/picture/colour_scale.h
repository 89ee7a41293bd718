// A strip that says what the colours of a picture mean.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/image.h"

namespace scanknit {

/// A label at a place of the strip, from 0, its left end, to 1.
struct ScaleLabel {
  double place = 0;
  std::string text;  ///< ASCII
};

/// The picture with a strip below it that shows `colours` from left to right, the labels, and a line of text.
/// Deterministic.
[[nodiscard]] ColourImage with_colour_scale(const ColourImage& picture, std::span<const Rgb8> colours,
                                            const std::vector<ScaleLabel>& labels, const std::string& title);

}  // namespace scanknit
