// Masks: which pixels of a picture are the thing.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>

#include "acquire/acquire_config.h"
#include "core/image.h"
#include "core/result.h"

namespace scanknit {

/// Folders of masks beside pictures, by their names.
inline constexpr std::array kMaskFolders = {"masks", "mask", "silhouettes"};

/// How much of each pixel is the thing: 0 to 255. In masks of classes, its class.
using Mask = Image<std::uint8_t>;

/// From this value on, a pixel is the thing.
inline constexpr std::uint8_t kHalfOfMask = 128;

/// The file in `masks` that belongs to a picture by its name, of "frame-17.depth.png": frame-17.depth.png,
/// frame-17.depth.png.png, frame-17.mask.png, frame-17.png, or the first of BOP's, frame-17_000000.png; of
/// "17_depth.png" or "17_rgb.png" also LabelFusion's 17_labels.png. Empty: there is none.
[[nodiscard]] std::filesystem::path find_mask(const std::filesystem::path& masks, const std::filesystem::path& picture);

/// A PNG of any kind; colours by their brightest channel. The first of BOP's masks, one of each thing in a picture, is
/// read together with the next ones (_000001 ...): thing n, counted from 0, has the value n + 1. With
/// config.mask_class, pixels of that value are 255, all others 0. Errors (kInput) name the file.
[[nodiscard]] Result<Mask> read_mask(const std::filesystem::path& path, const AcquireConfig& config);

/// The brightest channel.
[[nodiscard]] Mask brightest(const ColourImage& colour);

}  // namespace scanknit
