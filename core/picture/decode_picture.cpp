#include "core/picture/decode_picture.h"

#include "core/picture/jpeg_codec.h"
#include "core/picture/jpeg_structure.h"
#include "core/picture/png_codec.h"
#include "core/picture/png_structure.h"

namespace scanknit {

Result<ColourImage> decode_picture(std::span<const std::byte> bytes, const Limits& limits) {
  if (looks_like_jpeg(bytes)) {
    const auto header = check_jpeg(bytes, limits);
    return header ? decode_jpeg(bytes, *header) : header.error();
  }
  const auto file = check_png(bytes, limits);
  if (file) return decode_png_colour(*file);
  const bool is_other = file.error().message == "not a PNG file";
  return is_other ? Error{ErrorCode::kInput, "neither a PNG nor a JPEG file"} : file.error();
}

}  // namespace scanknit
