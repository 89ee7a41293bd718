#include "acquire/masks/mask_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>

#include "core/files/located.h"
#include "core/files/read_file.h"
#include "core/picture/png_codec.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFirstThing = "_000000.png";

Result<Mask> read_picture(const fs::path& path, const AcquireConfig& config) {
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
  return mask;
}

/// BOP's masks of one picture as one of labels; where two overlap, the last counts.
Result<Mask> read_things(const fs::path& first, const AcquireConfig& config) {
  constexpr int kMostThings = 255;
  const std::string path = first.string();
  const std::string begin = path.substr(0, path.size() - std::string_view(kFirstThing).size());
  Mask labels;
  std::error_code code;
  for (int thing = 0; thing < kMostThings; ++thing) {
    const fs::path file = begin + fmt::format("_{:06}.png", thing);
    if (!fs::is_regular_file(file, code)) break;
    const auto mask = read_picture(file, config);
    if (!mask) return mask;
    if (labels.empty()) labels = Mask(mask->width(), mask->height());
    if (mask->width() != labels.width() || mask->height() != labels.height()) {
      return Error{ErrorCode::kInput, "the mask has another size than that of the first thing in the picture",
                   file.string()};
    }
    for (std::size_t i = 0; i < labels.size(); ++i) {
      if (mask->pixels()[i] >= kHalfOfMask) labels.pixels()[i] = static_cast<std::uint8_t>(thing + 1);
    }
  }
  return labels;
}

/// LabelFusion's labels of "0000000001_depth.png" or "0000000001_rgb.png", 0000000001_labels.png; else empty.
std::string name_of_labels(std::string_view stem) {
  for (const std::string_view kind : {"_depth", "_rgb"}) {
    if (stem.ends_with(kind)) return std::string(stem.substr(0, stem.size() - kind.size())) + "_labels.png";
  }
  return {};
}

}  // namespace

fs::path find_mask(const fs::path& masks, const fs::path& picture) {
  std::error_code code;
  const std::string stem = picture.stem().string();
  const std::string first = stem.substr(0, stem.find('.'));
  for (const std::string& name : {stem + ".png", picture.filename().string() + ".png", first + ".mask.png",
                                  first + ".png", first + kFirstThing, name_of_labels(stem)}) {
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
  const bool has_things = path.filename().string().ends_with(kFirstThing);
  auto mask = has_things ? read_things(path, config) : read_picture(path, config);
  if (!mask) return mask;
  if (config.mask_class) {
    for (std::uint8_t& value : mask->pixels()) value = value == *config.mask_class ? 255 : 0;
  } else if (has_things && !config.keeps_labels) {
    for (std::uint8_t& value : mask->pixels()) value = value > 0 ? 255 : 0;
  }
  return mask;
}

}  // namespace scanknit
