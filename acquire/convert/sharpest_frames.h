// Chooses few frames of a recording for programs that train on pictures: the sharpest of each part of its way.
#pragma once

#include <cstddef>
#include <memory>
#include <stop_token>
#include <vector>

#include "acquire/convert/convert_recording.h"
#include "acquire/frame_source.h"
#include "core/image.h"
#include "core/result.h"

namespace scanknit {

/// The variance of the Laplacian (4 neighbours) of the grey picture (Pech-Pacheco et al. 2000, "Diatom autofocusing in
/// brightfield microscopy"); 0 for pictures of fewer than 3 x 3 pixels.
[[nodiscard]] double sharpness(const ColourImage& picture);

/// Plays `source` to its end. The way of the camera, in metres and radians together, is cut into `count` > 0 equal
/// parts; of a recording whose camera stands still, the frames. Returns the sharpest frame of each part that has one,
/// by its position among the frames, ascending. Frames without a pose are not chosen, nor those without colour where
/// others have it. Errors: those of the source; kInput (no frame has a pose).
[[nodiscard]] Result<std::vector<std::size_t>> find_sharpest_frames(FrameSource& source, std::size_t count,
                                                                    const ConvertProgress& progress,
                                                                    std::stop_token stop);

/// `source`, which begins anew, without the frames whose positions are not in `chosen`.
[[nodiscard]] std::unique_ptr<FrameSource> only_frames(std::unique_ptr<FrameSource> source,
                                                       std::vector<std::size_t> chosen);

}  // namespace scanknit
