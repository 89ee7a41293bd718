#include "acquire/masks/mask_files.h"

#include <algorithm>
#include <string>

#include "core/files/located.h"
#include "core/files/read_file.h"
#include "core/picture/png_codec.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

}  // namespace

fs::path find_mask(const fs::path& masks, const fs::path& picture) {
  std::error_code code;
  const std::string stem = picture.stem().string();
  const std::string first = stem.substr(0, stem.find('.'));
  for (const std::string& name :
       {stem + ".png", picture.filename().string() + ".png", first + ".mask.png", first + ".png"}) {
    const bool is_itself = masks / name == picture;
    if (!is_itself && fs::is_regular_file(masks / name, code)) return masks / name;
  }
  return {};
}

Mask brightest(const ColourImage& colour) {
  Mask mask(colour.width(), colour.height());
  std::transform(colour.pixels().begin(), colour.pixels().end(), mask.pixels().begin(), [](const Rgb8& c) {
    return std::max({c.r, c.g, c.b});
  });
  return mask;
}

Result<Mask> read_mask(const fs::path& path, const AcquireConfig& config) {
  const auto bytes = read_file(path, config.limits.max_image_bytes);
  if (!bytes) return bytes.error();
  const auto file = check_png(*bytes, config.limits);
  if (!file) return located(file.error(), path);
  Result<Mask> mask = Mask();
  if (file->header.is_grey && file->header.bit_depth == 8) {
    mask = decode_png_grey<std::uint8_t>(*file);
  } else {
    const auto colour = decode_png_colour(*file);
    mask = colour ? Result<Mask>(brightest(*colour)) : Result<Mask>(colour.error());
  }
  if (!mask) return located(mask.error(), path);
  if (config.mask_class) {
    for (std::uint8_t& value : mask->pixels()) value = value == *config.mask_class ? 255 : 0;
  }
  return mask;
}

}  // namespace scanknit
