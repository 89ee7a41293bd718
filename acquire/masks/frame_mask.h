// Masks on depth: which depth is fused, and how much each pixel counts.
#pragma once

#include <cstdint>

#include "acquire/acquire_config.h"
#include "acquire/masks/mask_files.h"
#include "core/camera.h"
#include "core/frame.h"

namespace scanknit {

/// So many pixels inside of a mask's rim count less, because masks are seldom exact there. The outermost is left out.
inline constexpr int kRimPixels = 4;

/// The mask in another size, by the nearest pixel.
[[nodiscard]] Mask resized(const Mask& mask, int width, int height);

/// The mask in another size, by the mean of what each pixel covers: outlines stay where they are, between pixels.
[[nodiscard]] Mask resized_by_mean(const Mask& mask, int width, int height);

/// Leaves the depth within the mask, which has its size, and sets Frame::weights: pixel n from the rim, counted from 0,
/// has the weight (n / kRimPixels)^2. With kFree, Frame::outside_m gets the rest. Beyond the picture's border nothing
/// is known, so that there is no rim.
void keep_within(const Mask& mask, MaskMeans means, Frame& frame);

/// The frame with what has this label left in it; `frame` has labels.
[[nodiscard]] Frame frame_of_class(const Frame& frame, std::uint8_t label, MaskMeans means);

}  // namespace scanknit
