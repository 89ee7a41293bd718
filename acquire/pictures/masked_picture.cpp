#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "acquire/masks/mask_files.h"
#include "acquire/pictures/picture_set.h"
#include "acquire/replay/picture_codec.h"
#include "acquire/replay/undistort.h"
#include "core/files/located.h"
#include "core/files/read_file.h"
#include "core/picture/decode_picture.h"
#include "core/picture/jpeg_structure.h"
#include "core/picture/png_codec.h"

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

/// Where a picture differs from the empty one, by more than pictures of the same thing do.
Result<Mask> difference(const ColourImage& picture, const ColourImage& empty, const fs::path& path) {
  if (picture.width() != empty.width() || picture.height() != empty.height()) {
    return mask_error("the empty picture is " + size_of(empty) + ", this one " + size_of(picture), path);
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

/// The mask of a picture whose bytes are these, from where there is one.
Result<Mask> mask_of(const PlacedPicture& picture, const std::vector<std::byte>& bytes, const ColourImage& colour,
                     const EmptyPicture& empty, const AcquireConfig& config) {
  if (!picture.mask.empty()) return read_mask(picture.mask, config);
  if (!empty.empty()) return difference(colour, empty, picture.picture);
  if (!looks_like_jpeg(bytes)) {
    const auto file = check_png(bytes, config.limits);
    if (file && file->header.has_alpha) return decode_png_alpha(*file);
  }
  return mask_error("no mask of this picture: expected " + picture.picture.stem().string() +
                        ".png in masks/, a picture with alpha, or an empty picture (acquire.background)",
                    picture.picture);
}

Result<void> check_mask(const Mask& mask, const fs::path& path) {
  constexpr std::uint8_t kHalf = 128;
  const auto thing =
      std::count_if(mask.pixels().begin(), mask.pixels().end(), [](std::uint8_t value) { return value >= kHalf; });
  if (thing == 0) return mask_error("the mask is empty: nothing of the picture is the thing", path);
  if (thing == static_cast<std::ptrdiff_t>(mask.size())) {
    return mask_error("the mask is white all over: it leaves no outline", path);
  }
  const int right = mask.width() - 1, bottom = mask.height() - 1;
  const std::array corners = {mask.at(0, 0), mask.at(right, 0), mask.at(0, bottom), mask.at(right, bottom)};
  if (std::all_of(corners.begin(), corners.end(), [](std::uint8_t value) { return value >= kHalf; })) {
    return mask_error(
        "all four corners of the picture belong to the thing: the mask is most likely inverted (the thing is white)",
        path);
  }
  return {};
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

Result<EmptyPicture> read_empty_picture(const AcquireConfig& config) {
  if (!config.background) return EmptyPicture();
  const auto bytes = read_file(*config.background, config.limits.max_image_bytes);
  if (!bytes) return bytes.error();
  auto picture = decode_picture(*bytes, config.limits);
  if (!picture) return located(picture.error(), *config.background);
  return *std::move(picture);
}

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
  if (auto sound = check_mask(*mask, mask_file); !sound) return sound.error();
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
