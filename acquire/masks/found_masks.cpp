#include "acquire/masks/found_masks.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "acquire/masks/masks_opencv.h"
#include "core/files/located.h"
#include "core/files/read_file.h"
#include "core/median.h"
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

/// A colour without its lightness, which scales with the light on it, and the lightness.
struct Chroma {
  Eigen::Vector2f vector;  ///< blue and red beside lightness
  float lightness;
};
Chroma chroma_of(const Rgb8& p) {
  const float lightness = 0.25F * static_cast<float>(p.r + 2 * p.g + p.b);
  return {{static_cast<float>(p.b) - lightness, static_cast<float>(p.r) - lightness}, lightness};
}

/// Of how much of the screen's colour there is in `colour`, along the screen's hue; other hues count against it.
float along(const Chroma& colour, const Eigen::Vector2f& hue) {
  constexpr float kOtherHues = 1.5F;  // a hue more than 34 degrees beside the screen's has nothing of it
  const float across = hue.x() * colour.vector.y() - hue.y() * colour.vector.x();
  return colour.vector.dot(hue) - kOtherHues * std::abs(across);
}

std::vector<Chroma> rim_of(const ColourImage& picture) {
  const int width = picture.width(), height = picture.height();
  const int rim = std::max(1, std::min(width, height) / 50);
  std::vector<Chroma> colours;
  for (int y = 0; y < height; ++y) {
    const bool is_whole_row = y < rim || y >= height - rim;
    for (int x = 0; x < width; ++x) {
      if (!is_whole_row && x == rim) x = std::max(x, width - rim);
      colours.push_back(chroma_of(picture.at(x, y)));
    }
  }
  return colours;
}

}  // namespace

MaskOrigin mask_origin(const AcquireConfig& config) {
  if (config.masks == kAlphaMasks) return MaskOrigin::kAlpha;
  if (config.masks == kChromaMasks) return MaskOrigin::kChroma;
  if (config.masks == kGrabCutMasks) return MaskOrigin::kGrabCut;
  if (config.masks) return MaskOrigin::kFiles;
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

// After P. Vlahos' colour difference: what a pixel has of the screen's hue, beside what the screen has of it at the
// same lightness.
Result<Mask> chroma_key(const ColourImage& picture) {
  constexpr float kLeastColour = 15;   // grey levels: less is as good as grey
  constexpr double kLeastShare = 0.5;  // of the rim; the thing may reach over the rest
  constexpr float kThing = 0.3F, kScreen = 0.7F;
  constexpr float kDark = 24;  // below it a hue is noise: the thing
  const std::vector<Chroma> rim = rim_of(picture);
  Eigen::Vector2f sum = Eigen::Vector2f::Zero();
  for (const Chroma& colour : rim) sum += colour.vector;
  const Eigen::Vector2f hue = sum.norm() > 0 ? sum.normalized() : Eigen::Vector2f::UnitX().eval();
  std::vector<float> saturations;
  for (const Chroma& colour : rim) {
    if (along(colour, hue) >= kLeastColour)
      saturations.push_back(along(colour, hue) / std::max(colour.lightness, kDark));
  }
  if (static_cast<double>(saturations.size()) < kLeastShare * static_cast<double>(rim.size())) {
    return found_mask_error(
        "most of the picture's rim is not of one strong colour: expected a green or blue screen "
        "behind the thing");
  }
  const float screen = median(std::move(saturations));
  Mask mask(picture.width(), picture.height());
  std::transform(picture.pixels().begin(), picture.pixels().end(), mask.pixels().begin(), [&](const Rgb8& pixel) {
    const Chroma colour = chroma_of(pixel);
    const float share = along(colour, hue) / (screen * std::max(colour.lightness, kDark));
    return static_cast<std::uint8_t>(std::lround(255 * std::clamp((kScreen - share) / (kScreen - kThing), 0.0F, 1.0F)));
  });
  return mask;
}

Result<Mask> grab_cut(const ColourImage& picture) {
  constexpr double kRim = 1.0 / 16;
  const auto opencv = load_masks_opencv();
  if (!opencv) return opencv.error();
  if (auto mask = (*opencv)->grab_cut(picture, kRim)) return *std::move(mask);
  return found_mask_error("GrabCut cannot cut this picture: it is too small, or of one colour");
}

Result<Mask> alpha_of(std::span<const std::byte> bytes, const Limits& limits) {
  const auto file = check_png(bytes, limits);
  if (!file || !file->header.has_alpha) {
    return found_mask_error("the picture has no alpha: expected a PNG with an alpha channel");
  }
  return decode_png_alpha(*file);
}

Result<Mask> find_mask(MaskOrigin origin, const ColourImage& picture, std::span<const std::byte> encoded,
                       const EmptyPicture& empty, const Limits& limits) {
  switch (origin) {
    case MaskOrigin::kChroma: return chroma_key(picture);
    case MaskOrigin::kGrabCut: return grab_cut(picture);
    case MaskOrigin::kDifference: return difference(picture, empty);
    case MaskOrigin::kAlpha: return alpha_of(encoded, limits);
    case MaskOrigin::kNone:
    case MaskOrigin::kFiles: break;
  }
  return found_mask_error("no mask is found in pictures without acquire.masks or acquire.background");
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
