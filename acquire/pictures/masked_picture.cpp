#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "acquire/masks/found_masks.h"
#include "acquire/masks/mask_files.h"
#include "acquire/pictures/picture_set.h"
#include "acquire/replay/picture_codec.h"
#include "acquire/replay/undistort.h"
#include "core/files/located.h"
#include "core/files/read_file.h"
#include "core/picture/decode_picture.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

Error mask_error(std::string message, const fs::path& path) {
  return {ErrorCode::kInput, std::move(message), path.string()};
}

template <typename Picture>
std::string size_of(const Picture& picture) {
  return std::to_string(picture.width()) + " x " + std::to_string(picture.height());
}

/// The mask of a picture whose bytes are these, from where there is one.
Result<Mask> mask_of(const PlacedPicture& picture, const std::vector<std::byte>& bytes, const ColourImage& colour,
                     const EmptyPicture& empty, const AcquireConfig& config) {
  if (!picture.mask.empty()) return read_mask(picture.mask, config);
  const MaskOrigin origin = mask_origin(config);
  if (origin == MaskOrigin::kChroma || origin == MaskOrigin::kGrabCut || origin == MaskOrigin::kDifference) {
    auto mask = find_mask(origin, colour, bytes, empty, config.limits);
    return mask ? std::move(mask) : Result<Mask>(located(mask.error(), picture.picture));
  }
  if (auto mask = alpha_of(bytes, config.limits)) return mask;
  return mask_error(
      "no mask of this picture: expected " + picture.picture.stem().string() +
          ".png in masks/, a picture with alpha, a screen of one colour (acquire.masks=chroma), an empty picture "
          "(acquire.background), or a thing that stands out (acquire.masks=grabcut)",
      picture.picture);
}

Mask undistorted(const Mask& mask, const CameraModel& camera) {
  ColourImage grey(mask.width(), mask.height());
  std::transform(mask.pixels().begin(), mask.pixels().end(), grey.pixels().begin(), [](std::uint8_t value) {
    return Rgb8{value, value, value};
  });
  return brightest(undistort(grey, camera.intrinsics, camera.distortion));
}

/// Squares of `factor` pixels by their mean; what is left over at the right and at the bottom is cut off.
template <typename Pixel, std::size_t kChannels>
Image<Pixel> smaller(const Image<Pixel>& image, int factor) {
  static_assert(sizeof(Pixel) == kChannels);
  Image<Pixel> small(image.width() / factor, image.height() / factor);
  for (int y = 0; y < small.height(); ++y) {
    for (int x = 0; x < small.width(); ++x) {
      std::array<int, kChannels> sums{};
      for (int dy = 0; dy < factor; ++dy) {
        for (int dx = 0; dx < factor; ++dx) {
          const auto* channels = reinterpret_cast<const std::uint8_t*>(&image.at(x * factor + dx, y * factor + dy));
          for (std::size_t k = 0; k < kChannels; ++k) sums[k] += channels[k];
        }
      }
      auto* mean = reinterpret_cast<std::uint8_t*>(&small.at(x, y));
      const int count = factor * factor;
      for (std::size_t k = 0; k < kChannels; ++k) mean[k] = static_cast<std::uint8_t>((sums[k] + count / 2) / count);
    }
  }
  return small;
}

void make_smaller(std::size_t most_pixels, MaskedPicture& picture) {
  const double times = std::sqrt(static_cast<double>(picture.mask.size()) / static_cast<double>(most_pixels));
  const int factor = static_cast<int>(std::ceil(times));
  if (factor < 2 || picture.mask.width() < 2 * factor || picture.mask.height() < 2 * factor) return;
  picture.mask = smaller<std::uint8_t, 1>(picture.mask, factor);
  picture.colour = smaller<Rgb8, 3>(picture.colour, factor);
  CameraIntrinsics& k = picture.camera;
  k = {picture.mask.width(), picture.mask.height(),       k.fx / factor,
       k.fy / factor,        (k.cx + 0.5) / factor - 0.5, (k.cy + 0.5) / factor - 0.5};
}

}  // namespace

Result<MaskedPicture> read_masked_picture(const PlacedPicture& picture, const EmptyPicture& empty,
                                          const AcquireConfig& config, std::size_t most_pixels) {
  const auto bytes = read_file(picture.picture, config.limits.max_image_bytes);
  if (!bytes) return bytes.error();
  auto colour = decode_picture(*bytes, config.limits);
  if (!colour) return located(colour.error(), picture.picture);
  auto mask = mask_of(picture, *bytes, *colour, empty, config);
  if (!mask) return mask.error();
  const fs::path& mask_file = picture.mask.empty() ? picture.picture : picture.mask;
  if (mask->width() != colour->width() || mask->height() != colour->height()) {
    return mask_error("the mask is " + size_of(*mask) + ", the picture " + size_of(*colour), mask_file);
  }
  if (auto sound = check_silhouette(*mask); !sound) return located(sound.error(), mask_file);
  CameraModel camera = picture.camera;
  CameraIntrinsics& k = camera.intrinsics;
  if (k.width == 0 && k.height == 0) {
    k.width = colour->width();
    k.height = colour->height();
  }
  if (k.width != colour->width() || k.height != colour->height()) {
    return mask_error("the picture is " + size_of(*colour) + ", its camera's " + std::to_string(k.width) + " x " +
                          std::to_string(k.height),
                      picture.picture);
  }
  if (!k.is_valid()) return mask_error("the camera has no valid focal length", picture.picture);
  MaskedPicture read{*std::move(colour), *std::move(mask), k};
  if (camera.distortion != Distortion{}) {
    read.colour = undistort(read.colour, k, camera.distortion);
    read.mask = undistorted(read.mask, camera);
  }
  make_smaller(most_pixels, read);
  return read;
}

}  // namespace scanknit
