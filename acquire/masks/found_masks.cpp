#include "acquire/masks/found_masks.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "core/files/located.h"
#include "core/files/read_file.h"
#include "core/picture/decode_picture.h"
#include "core/picture/png_codec.h"

namespace scanknit {
namespace {

Error found_mask_error(std::string message) {
  return {ErrorCode::kInput, std::move(message)};
}

std::string sides_of(const ColourImage& picture) {
  return std::to_string(picture.width()) + " x " + std::to_string(picture.height());
}

}  // namespace

MaskOrigin mask_origin(const AcquireConfig& config) {
  if (config.masks) return *config.masks == kAlphaMasks ? MaskOrigin::kAlpha : MaskOrigin::kFiles;
  return config.background ? MaskOrigin::kDifference : MaskOrigin::kNone;
}

Result<EmptyPicture> read_empty_picture(const AcquireConfig& config) {
  if (!config.background) return EmptyPicture();
  const auto bytes = read_file(*config.background, config.limits.max_image_bytes);
  if (!bytes) return bytes.error();
  auto picture = decode_picture(*bytes, config.limits);
  if (!picture) return located(picture.error(), *config.background);
  return *std::move(picture);
}

Result<Mask> difference(const ColourImage& picture, const EmptyPicture& empty) {
  if (picture.width() != empty.width() || picture.height() != empty.height()) {
    return found_mask_error("the empty picture is " + sides_of(empty) + ", this one " + sides_of(picture));
  }
  constexpr int kLeast = 20, kSure = 44;  // of 255, in the channel that differs most; between them a share
  Mask mask(picture.width(), picture.height());
  for (std::size_t i = 0; i < mask.size(); ++i) {
    const Rgb8 &a = picture.pixels()[i], &b = empty.pixels()[i];
    const int most = std::max({std::abs(a.r - b.r), std::abs(a.g - b.g), std::abs(a.b - b.b)});
    mask.pixels()[i] = static_cast<std::uint8_t>(std::clamp((most - kLeast) * 255 / (kSure - kLeast), 0, 255));
  }
  return mask;
}

Result<Mask> alpha_of(std::span<const std::byte> bytes, const Limits& limits) {
  const auto file = check_png(bytes, limits);
  if (!file || !file->header.has_alpha) {
    return found_mask_error("the picture has no alpha: expected a PNG with an alpha channel");
  }
  return decode_png_alpha(*file);
}

Result<void> check_silhouette(const Mask& mask) {
  const auto is_thing = [](std::uint8_t value) { return value >= kHalfOfMask; };
  const auto thing = std::count_if(mask.pixels().begin(), mask.pixels().end(), is_thing);
  if (thing == 0) return found_mask_error("the mask is empty: nothing of the picture is the thing");
  if (thing == static_cast<std::ptrdiff_t>(mask.size())) {
    return found_mask_error("the mask is white all over: it leaves no outline");
  }
  const int right = mask.width() - 1, bottom = mask.height() - 1;
  const std::array corners = {mask.at(0, 0), mask.at(right, 0), mask.at(0, bottom), mask.at(right, bottom)};
  if (std::all_of(corners.begin(), corners.end(), is_thing)) {
    return found_mask_error(
        "all four corners of the picture belong to the thing: the mask is most likely inverted (the thing is white)");
  }
  return {};
}

}  // namespace scanknit
