// Masks that are found in the pictures themselves: their alpha, what is not of the screen's colour, what differs from
// an empty picture, or what GrabCut cuts out.
#pragma once

#include <cstddef>
#include <span>

#include "acquire/acquire_config.h"
#include "acquire/masks/mask_files.h"
#include "core/image.h"
#include "core/limits.h"
#include "core/result.h"

namespace scanknit {

/// The value of acquire.masks that is no folder: masks are the colour pictures' alpha. A folder of that name is
/// "./alpha".
inline constexpr const char* kAlphaMasks = "alpha";

/// Likewise: the thing stood before a screen of one strong colour. A folder of that name is "./chroma".
inline constexpr const char* kChromaMasks = "chroma";

/// Likewise: nothing is known but that the thing is within the picture. A folder of that name is "./grabcut".
inline constexpr const char* kGrabCutMasks = "grabcut";

/// Where the masks of frames come from.
enum class MaskOrigin {
  kNone,
  kFiles,       ///< the folder acquire.masks
  kAlpha,       ///< acquire.masks is kAlphaMasks
  kChroma,      ///< ... kChromaMasks
  kGrabCut,     ///< ... kGrabCutMasks
  kDifference,  ///< from the picture acquire.background, without acquire.masks
};
[[nodiscard]] MaskOrigin mask_origin(const AcquireConfig& config);

/// The picture without the thing, from which the difference is taken; empty: none.
using EmptyPicture = ColourImage;

/// Empty without `config.background`. Errors (kInput): it cannot be read.
[[nodiscard]] Result<EmptyPicture> read_empty_picture(const AcquireConfig& config);

/// How surely each pixel is the thing: where a picture differs from the empty one by more than pictures of the same
/// thing do. Error (kInput, without `where`): their sizes differ.
[[nodiscard]] Result<Mask> difference(const ColourImage& picture, const EmptyPicture& empty);

/// How surely each pixel is not of the screen, whose colour is that of the picture's rim: by hue and saturation, so
/// that the screen may be lit unevenly. Error (kInput, without `where`): the rim has no strong colour that most of it
/// shares.
[[nodiscard]] Result<Mask> chroma_key(const ColourImage& picture);

/// What stands out from the picture's rim, a sixteenth of its sides, by its colours: a help where the background is no
/// screen, to be looked at. Errors: kInternal: load_masks_opencv()'s; kInput (without `where`): it cannot be cut.
[[nodiscard]] Result<Mask> grab_cut(const ColourImage& picture);

/// The alpha of a picture whose file's bytes are these. Errors (kInput, without `where`): no PNG, or one without alpha.
[[nodiscard]] Result<Mask> alpha_of(std::span<const std::byte> bytes, const Limits& limits);

/// The mask of a picture by one of these, not kNone or kFiles. `encoded`: its file's bytes, for its alpha. Errors:
/// theirs.
[[nodiscard]] Result<Mask> find_mask(MaskOrigin origin, const ColourImage& picture, std::span<const std::byte> encoded,
                                     const EmptyPicture& empty, const Limits& limits);

/// Errors (kInput, without `where`): a mask in which nothing is the thing, or everything, or most likely what is not
/// the thing: all four corners.
[[nodiscard]] Result<void> check_silhouette(const Mask& mask);

}  // namespace scanknit
