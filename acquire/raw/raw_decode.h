// Decodes a scanner's bytes to a Frame, both in live capture and in the replay of a recording.
#pragma once

#include "acquire/raw_frame.h"
#include "core/frame.h"
#include "core/image.h"
#include "core/limits.h"
#include "core/result.h"

namespace scanknit {

class PairDepth;

/// Z16 as metres; 0 and 65535 are "no return". Errors (kInput, without `where`): another format, not width x height
/// pixels, beyond the limits.
[[nodiscard]] Result<DepthImage> decode_raw_depth(const RawFrame& frame, double depth_unit_m, const Limits& limits);

/// YUYV and UYVY by BT.601 (video range), MJPEG (also without Huffman tables, as cameras send it), RGB and BGR. Errors
/// (kInput, without `where`): Z16, Y8I, not width x height pixels, truncated or corrupt, beyond the limits.
[[nodiscard]] Result<ColourImage> decode_raw_colour(const RawFrame& frame, const Limits& limits);

struct GreyPair {
  ColourImage left, right;
};
/// Errors as above: a format other than Y8I.
[[nodiscard]] Result<GreyPair> decode_raw_pair(const RawFrame& frame, const Limits& limits);

/// Makes the frame of a depth picture and its colour picture (or null): decoded, undistorted, with its cameras, the
/// depth picture's sequence number and the camera's clock. A pair (Y8I) becomes depth by `pairs` - none at all where
/// hardly anything matches - and colour by its left picture, if there is no other. Without a colour camera in
/// `calibration`, colour counts as registered to depth. Pose and normals stay empty. Errors: see above; a picture whose
/// size differs from its camera's; no depth camera; a pair without `pairs`.
[[nodiscard]] Result<Frame> decode_raw_frame(const RawFrame& depth, const RawFrame* colour,
                                             const RawCalibration& calibration, const Limits& limits,
                                             const PairDepth* pairs = nullptr);

}  // namespace scanknit
